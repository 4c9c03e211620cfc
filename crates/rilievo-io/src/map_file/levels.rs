//! The payload of a min-max map: the levels of a pyramid in either layout.

use rilievo::map::{Layout, Level, LevelBounds};

use super::{PIECE, Payload, pieces};

/// Hands over the bytes of all levels.
pub(super) fn give(levels: &[Level], mut take: impl FnMut(&[u8])) {
    for level in levels {
        match &level.bounds {
            LevelBounds::Wide { max, min } => {
                for bounds in [max, min] {
                    pieces(bounds.as_flattened(), |v| v.to_le_bytes(), &mut take);
                }
            }
            LevelBounds::Tiny { max, min, .. } => {
                for bounds in [max, min] {
                    bounds.as_flattened().chunks(PIECE).for_each(&mut take);
                }
            }
        }
    }
    // At the end of it all: ranges alone need not fill whole words of the checksum.
    let ranges: Vec<u16> = levels.iter().flat_map(ranges).copied().collect();
    pieces(&ranges, |v| v.to_le_bytes(), take);
}

/// The ranges of the nodes of a tiny level.
fn ranges(level: &Level) -> &[u16] {
    match &level.bounds {
        LevelBounds::Wide { .. } => &[],
        LevelBounds::Tiny { range, .. } => range.as_flattened(),
    }
}

/// Takes levels with these nodes off a payload.
pub(super) fn take(
    payload: &mut Payload<'_>,
    layout: Layout,
    nodes: Vec<[u32; 2]>,
) -> std::io::Result<Vec<Level>> {
    let mut levels = Vec::new();
    for nodes in nodes {
        let count = nodes[0] as usize * nodes[1] as usize;
        let bounds = match layout {
            Layout::Default => LevelBounds::Wide {
                max: payload.codes(count, wide)?,
                min: payload.codes(count, wide)?,
            },
            Layout::Tiny => LevelBounds::Tiny {
                max: payload.codes(count, |lanes: [u8; 16]| lanes)?,
                min: payload.codes(count, |lanes: [u8; 16]| lanes)?,
                range: Vec::new(),
            },
        };
        levels.push(Level { nodes, bounds });
    }
    for level in &mut levels {
        if let LevelBounds::Tiny { max, range, .. } = &mut level.bounds {
            *range = payload.codes(max.len(), |[a, b, c, d]| {
                [u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d])]
            })?;
        }
    }
    Ok(levels)
}

/// Sixteen `u16` lanes.
fn wide(bytes: [u8; 32]) -> [u16; 16] {
    let mut lanes = bytes.as_chunks::<2>().0.iter();
    std::array::from_fn(|_| lanes.next().map_or(0, |b| u16::from_le_bytes(*b)))
}
