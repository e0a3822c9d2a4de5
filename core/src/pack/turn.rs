//! The ways in which a rectangle lies on a grid.

/// One of the eight ways to lay a square on itself, or one rectangle on another: the axes swapped or not, then
/// each run backwards or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Turn {
    pub is_swapped: bool,
    /// Along x and y of the result.
    pub is_flipped: [bool; 2],
}

impl Turn {
    pub const NONE: Self = Self { is_swapped: false, is_flipped: [false; 2] };
    pub const SWAP: Self = Self { is_swapped: true, is_flipped: [false; 2] };

    /// How many there are.
    pub const COUNT: u32 = 8;

    pub fn all() -> impl Iterator<Item = Self> {
        (0..Self::COUNT).map(Self::numbered)
    }

    /// The one of a number below [`Turn::COUNT`].
    pub fn numbered(number: u32) -> Self {
        let bit = |place: u32| number >> place & 1 == 1;
        Self { is_swapped: bit(2), is_flipped: [bit(0), bit(1)] }
    }

    /// The two entries of a pair by axis, as the turned rectangle has them.
    pub fn pair<T: Copy>(self, [x, y]: [T; 2]) -> [T; 2] {
        if self.is_swapped { [y, x] } else { [x, y] }
    }

    /// Where a point of a rectangle of `size` comes to lie; both ends of a side are points of it.
    pub fn point(self, point: [u32; 2], size: [u32; 2]) -> [u32; 2] {
        let (point, size) = (self.pair(point), self.pair(size));
        [0, 1].map(|k| if self.is_flipped[k] { size[k] - point[k] } else { point[k] })
    }

    /// This turn and then another.
    pub fn then(self, next: Self) -> Self {
        let flipped = next.pair(self.is_flipped);
        Self {
            is_swapped: self.is_swapped != next.is_swapped,
            is_flipped: [0, 1].map(|k| flipped[k] != next.is_flipped[k]),
        }
    }
}
