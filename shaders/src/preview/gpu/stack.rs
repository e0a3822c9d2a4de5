//! All levels of a mesh color texture in one image: shelves from the top, a texel of gap between levels.

use glam::Vec2;

use crate::twins::MctLevel;

/// Size of the stack and where each level stands in it.
#[derive(Clone, Debug, PartialEq)]
pub struct Stack {
    pub size: [u32; 2],
    pub levels: Vec<MctLevel>,
}

/// Texels between two levels. Sampling never reads them; they keep rounding harmless.
const GAP: u32 = 1;

/// Lays out levels of these sizes.
pub fn stack(sizes: &[[u32; 2]]) -> Stack {
    let area: f64 = sizes.iter().map(|[w, h]| f64::from(w + GAP) * f64::from(h + GAP)).sum();
    let widest = sizes.iter().map(|size| size[0]).max().unwrap_or(1);
    let width = widest.max((area.sqrt() * 1.1) as u32);
    let mut levels = Vec::with_capacity(sizes.len());
    let (mut at, mut shelf_height, mut used) = ([0, 0], 0, [1, 1]);
    for &[level_width, level_height] in sizes {
        if at[0] > 0 && at[0] + level_width > width {
            at = [0, at[1] + shelf_height + GAP];
            shelf_height = 0;
        }
        levels.push(MctLevel {
            origin: Vec2::new(at[0] as f32, at[1] as f32),
            size: Vec2::new(level_width as f32, level_height as f32),
        });
        used = [used[0].max(at[0] + level_width), used[1].max(at[1] + level_height)];
        shelf_height = shelf_height.max(level_height);
        at[0] += level_width + GAP;
    }
    Stack { size: used, levels }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_do_not_touch_and_lie_inside() {
        for sizes in [
            vec![[2500, 2500], [1300, 1290], [700, 690], [400, 380], [250, 230], [250, 230], [250, 230]],
            vec![[7, 1], [7, 1], [7, 1]],
            vec![[1, 900], [3, 500], [1, 1]],
            vec![[1, 1]],
        ] {
            let stack = stack(&sizes);
            for (number, level) in stack.levels.iter().enumerate() {
                let end = level.origin + level.size;
                assert!(end.x <= stack.size[0] as f32 && end.y <= stack.size[1] as f32);
                for other in &stack.levels[..number] {
                    let gap =
                        (level.origin - (other.origin + other.size)).max(other.origin - end).max_element();
                    assert!(gap >= GAP as f32, "{level:?} {other:?}");
                }
            }
        }
    }
}
