//! Sampler wrap modes (glTF 2.0, section 3.8.4.2), applied to whole texel numbers.

/// What happens outside [0, 1) along one axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum WrapMode {
    #[default]
    Repeat,
    MirroredRepeat,
    ClampToEdge,
}

/// Wrap modes along u and v.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Wrap {
    pub s: WrapMode,
    pub t: WrapMode,
}

impl WrapMode {
    /// The texel in `0..size` that stands at texel number `at`; `size >= 1`.
    pub fn apply(self, at: i64, size: u32) -> u32 {
        let size = i64::from(size);
        let texel = match self {
            WrapMode::Repeat => at.rem_euclid(size),
            WrapMode::MirroredRepeat => {
                let phase = at.rem_euclid(2 * size);
                if phase < size { phase } else { 2 * size - 1 - phase }
            }
            WrapMode::ClampToEdge => at.clamp(0, size - 1),
        };
        texel as u32
    }
}
