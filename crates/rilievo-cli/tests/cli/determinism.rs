//! The same input gives the same bytes for any number of threads.

use crate::support::Folder;

#[test]
fn threads_do_not_show_in_any_picture() {
    let folder = Folder::new().with_scene();
    let kinds = [
        ("a.exr", "--aov P,N,Steps"),
        ("b.png", ""),
        ("c.exr", "--method distance"),
        ("d.exr", "--integrator aov"),
    ];
    for (file, flags) in kinds {
        let render = |threads: u32| {
            folder
                .run(&format!("render scene.toml -o {file} {flags} --threads {threads}"))
                .expect(0);
            folder.bytes(file)
        };
        let one = render(1);
        assert_eq!(render(2), one, "{file} with 2 threads");
        assert_eq!(render(7), one, "{file} with 7 threads");
    }
}

#[test]
fn a_map_is_baked_to_the_same_bytes_twice() {
    let folder = Folder::new().with_scene();
    for kind in ["published", "boxes", "corrected"] {
        let bake = |file: &str| {
            let words = format!("bake distance map.png -o {file} --kind {kind} --size 16,16,8");
            folder.run(&words).expect(0);
            folder.bytes(file)
        };
        assert_eq!(bake("a.map"), bake("b.map"), "{kind}");
    }
}
