//! URIs of buffers and images: data inside the URI, or the name of a file beside.

use std::path::{Path, PathBuf};

/// What a URI points at.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Target {
    /// Bytes, and their media type in small letters.
    Data { media: String, bytes: Vec<u8> },
    /// A file, relative to the document.
    File(PathBuf),
    /// Something this library does not open.
    Elsewhere,
}

/// Understands `uri`, of a document at `path`; an error says what is wrong with it.
pub(super) fn resolve(uri: &str, path: &Path) -> Result<Target, &'static str> {
    if let Some(rest) = uri.strip_prefix("data:") {
        return data(rest);
    }
    if let Some((scheme, _)) = uri.split_once(':')
        && !scheme.contains(['/', '?', '#'])
    {
        let first = scheme.chars().next().is_some_and(|c| c.is_ascii_alphabetic());
        let rest = scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c));
        return if first && rest { Ok(Target::Elsewhere) } else { Err("a scheme that is none") };
    }
    if uri.starts_with('/') {
        return Ok(Target::Elsewhere);
    }
    let name = percent_decoded(uri)?;
    match name.is_empty() || name.contains('\0') {
        true => Err("no name of a file"),
        false => Ok(Target::File(path.parent().unwrap_or(Path::new("")).join(name))),
    }
}

fn data(rest: &str) -> Result<Target, &'static str> {
    let (head, body) = rest.split_once(',').ok_or("data without a comma")?;
    let mut parameters = head.split(';');
    let media = parameters.next().unwrap_or_default().to_ascii_lowercase();
    let mut coded = false;
    for parameter in parameters {
        match parameter {
            _ if coded => return Err("a parameter after base64"),
            "base64" => coded = true,
            parameter if parameter.contains('=') => {}
            _ => return Err("a parameter without a value"),
        }
    }
    let bytes = match coded {
        true => base64(body.as_bytes())?,
        false => percent_decoded(body)?.into_bytes(),
    };
    Ok(Target::Data { media, bytes })
}

fn percent_decoded(text: &str) -> Result<String, &'static str> {
    let (mut bytes, mut rest) = (Vec::with_capacity(text.len()), text.as_bytes());
    while let [first, tail @ ..] = rest {
        rest = match (first, tail) {
            (b'%', [high, low, after @ ..]) => {
                let digit = |b: &u8| char::from(*b).to_digit(16).ok_or("a % without two digits");
                bytes.push((16 * digit(high)? + digit(low)?) as u8);
                after
            }
            (b'%', _) => return Err("a % without two digits"),
            _ => {
                bytes.push(*first);
                tail
            }
        };
    }
    String::from_utf8(bytes).map_err(|_| "bytes that are not UTF-8")
}

/// Decodes RFC 4648's alphabet, with or without `=` at the end.
fn base64(text: &[u8]) -> Result<Vec<u8>, &'static str> {
    let end = text.iter().rposition(|b| *b != b'=').map_or(0, |last| last + 1);
    if text.len() - end > 2 || end % 4 == 1 {
        return Err("base64 of a wrong length");
    }
    let mut bytes = Vec::with_capacity(end / 4 * 3 + 2);
    for group in text[..end].chunks(4) {
        let mut bits = 0_u32;
        for k in 0..4 {
            let digit = match group.get(k).copied().unwrap_or(b'A') {
                b @ b'A'..=b'Z' => b - b'A',
                b @ b'a'..=b'z' => b - b'a' + 26,
                b @ b'0'..=b'9' => b - b'0' + 52,
                b'+' | b'-' => 62,
                b'/' | b'_' => 63,
                _ => return Err("a character that is not base64"),
            };
            bits = bits << 6 | u32::from(digit);
        }
        bytes.extend(&bits.to_be_bytes()[1..group.len()]);
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_every_length_is_decoded() {
        for (text, want) in [
            ("", ""),
            ("Zg==", "f"),
            ("Zg", "f"),
            ("Zm8=", "fo"),
            ("Zm9v", "foo"),
            ("Zm9vYg==", "foob"),
        ] {
            assert_eq!(base64(text.as_bytes()).unwrap(), want.as_bytes());
        }
        for bad in ["Z", "Zg===", "Zm`v", "Zm9vY"] {
            assert!(base64(bad.as_bytes()).is_err(), "{bad}");
        }
    }

    #[test]
    fn uris_are_data_files_or_elsewhere() {
        let of = |uri| resolve(uri, Path::new("dir/a.gltf"));
        assert_eq!(of("a%20b.bin"), Ok(Target::File("dir/a b.bin".into())));
        assert_eq!(of("x/a:b.bin"), Ok(Target::File("dir/x/a:b.bin".into())));
        assert_eq!(of("http://example.com/a.bin"), Ok(Target::Elsewhere));
        assert_eq!(of("/etc/hosts"), Ok(Target::Elsewhere));
        let data = Target::Data { media: "image/png".to_owned(), bytes: b"foo".to_vec() };
        assert_eq!(of("data:image/PNG;a=b;base64,Zm9v"), Ok(data));
        for bad in [":", "", "data:x", "data:a/b;;base64,AA==", "a%2", "a%zz", "data:;base64,`"] {
            assert!(of(bad).is_err(), "{bad}");
        }
    }
}
