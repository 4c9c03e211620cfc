//! Texture sets as they are shipped: the folders of the gallery.

use std::path::Path;

use rilievo_io::Limits;
use rilievo_io::image::HeightOptions;
use rilievo_io::scene::{LoadOptions, SceneFile};
use rilievo_io::texture_set::{MapRole, TextureSet};

#[test]
fn folders_of_the_gallery_drop_in() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/maps");
    let limits = Limits::default();
    for (folder, albedo, displacement, scale) in [
        ("moss", Some("Moss001_1K_Color.png"), "Moss001_1K_Displacement.png", 0.05),
        ("facade", Some("Facade001_1K_Color.png"), "Facade001_1K_Displacement.png", 0.05),
        ("canyon", Some("Canyon-Diffuse.jpg"), "Canyon-Height.jpg", 0.05),
        ("jacksboro", None, "jacksboro_metres_u16.png", 0.1 / (840.0 / 65535.0)),
    ] {
        let folder = root.join(folder);
        let set = TextureSet::find(&folder, &limits).unwrap();
        let name = |role| set.map(role).map(|m| m.path.file_name().unwrap().to_str().unwrap());
        assert_eq!(name(MapRole::Albedo), albedo);
        assert_eq!(name(MapRole::Displacement), Some(displacement));
        let heights = set.heights(&HeightOptions::default(), &limits).unwrap();
        let assumed = set.assumed(&heights, &limits).unwrap();
        assert!((assumed.scale / scale - 1.0).abs() < 1e-9, "{assumed:?}");
        assert!(!assumed.invert && assumed.agreement.is_none());
        let scene = SceneFile::present(&folder, &limits).unwrap();
        let loaded = scene.load(&LoadOptions::default()).unwrap();
        assert_eq!(loaded.scene.world().surfaces().len(), 2);
        assert!(loaded.notes.len() >= 2, "{:?}", loaded.notes);
    }
}
