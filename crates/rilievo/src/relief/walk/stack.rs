//! [`Stack`]: what is left to visit of a descent, sixteen bits a level.

/// Levels in the first word.
const LOW_LEVELS: u32 = 4;

/// Children still to be visited: bit `16 level + lane`. The deepest level comes first, and in it the
/// lane met first. The node that a lane belongs to is not stored; see [`child`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Stack {
    /// Levels 0 to 3: up to 1024 cells a side.
    low: u64,
    /// Levels 4 to 7.
    high: u64,
    /// Levels 8 to 11.
    highest: u64,
}

impl Stack {
    /// Adds the children of a node of `level`.
    #[inline(always)]
    pub fn push(&mut self, level: u32, lanes: u16) {
        let bits = u64::from(lanes) << (16 * (level % LOW_LEVELS));
        if level < LOW_LEVELS {
            self.low |= bits;
        } else if level < 2 * LOW_LEVELS {
            self.high |= bits;
        } else {
            self.highest |= bits;
        }
    }

    /// Takes the level and lane to visit next.
    #[inline(always)]
    pub fn pop(&mut self) -> Option<(u32, i32)> {
        // Word by word, without a reference to the one chosen: they stay in registers.
        if self.low != 0 {
            let bit = self.low.trailing_zeros();
            self.low &= self.low - 1;
            return Some((bit / 16, (bit % 16) as i32));
        }
        if self.high != 0 {
            let bit = self.high.trailing_zeros();
            self.high &= self.high - 1;
            return Some((LOW_LEVELS + bit / 16, (bit % 16) as i32));
        }
        if self.highest != 0 {
            let bit = self.highest.trailing_zeros();
            self.highest &= self.highest - 1;
            return Some((2 * LOW_LEVELS + bit / 16, (bit % 16) as i32));
        }
        None
    }
}

/// Corner of the block at a lane of the node of `level` that holds `cell`.
#[inline(always)]
pub(crate) fn child(cell: [i32; 2], level: u32, lane: i32) -> [i32; 2] {
    let side = 2 * level + 2;
    let node = -1i32 << (side + 2);
    [(cell[0] & node) + ((lane & 3) << side), (cell[1] & node) + ((lane >> 2) << side)]
}

/// The lane that holds `cell` in its node of `level`.
#[inline(always)]
pub(crate) fn lane_of(cell: [i32; 2], level: u32) -> u32 {
    let x = (cell[0] >> (2 * level + 2)) as u32 & 3;
    let y = (cell[1] >> (2 * level + 2)) as u32 & 3;
    4 * y + x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deepest_level_comes_first_and_in_it_the_lowest_lane() {
        let mut stack = Stack::default();
        let nodes = [(11, 0x8001), (8, 0x10), (5, 0xF000), (4, 0x2), (3, 0x18), (0, 0x8100)];
        let mut want = Vec::new();
        for (level, lanes) in nodes {
            stack.push(level, lanes);
            let set = (0..16).filter(|lane| lanes >> lane & 1 == 1).rev();
            want.extend(set.map(|lane| (level, lane)));
        }
        while let Some(next) = want.pop() {
            assert_eq!(stack.pop(), Some(next));
        }
        assert_eq!(stack.pop(), None);
    }

    #[test]
    fn children_are_found_from_any_cell_of_their_node_also_mirrored() {
        for cell in [[37, 1000], [-38, -1], [-1000, 77]] {
            for level in 0..5 {
                let side = 4 << (2 * level);
                let node = cell.map(|g: i32| g.div_euclid(4 * side) * 4 * side);
                for lane in 0..16 {
                    let want = [node[0] + (lane % 4) * side, node[1] + (lane / 4) * side];
                    assert_eq!(child(cell, level, lane), want);
                    assert_eq!(lane_of(want, level), lane as u32);
                }
            }
        }
    }
}
