//! Charts in shelves: the tallest first, from left to right, a new shelf where one is full.

use std::cmp::Reverse;

use super::super::Limits;
use crate::error::{Error, ErrorCode, Result};

/// Where charts stand in an image.
#[derive(Debug)]
pub struct Atlas {
    pub size: [u32; 2],
    /// The first texel of each chart.
    pub places: Vec<[u32; 2]>,
}

/// Sets out charts of these sizes, as nearly square as the limit on an image's side allows.
///
/// # Errors
/// `ImageTooLarge` where the image would be over a limit.
pub fn place(charts: &[[u32; 2]], limits: &Limits) -> Result<Atlas> {
    let side_limit = u64::from(limits.image_side);
    let area: u64 = charts.iter().map(|&[width, height]| u64::from(width) * u64::from(height)).sum();
    let widest = charts.iter().map(|chart| u64::from(chart[0])).max().unwrap_or(1);
    let mut order: Vec<usize> = (0..charts.len()).collect();
    order.sort_by_key(|&chart| (Reverse(charts[chart][1]), Reverse(charts[chart][0]), chart));
    // Coordinates over a power of two are exact.
    let mut width = area.isqrt().max(widest).next_power_of_two();
    let mut shelves = Shelves::new(charts, &order, width);
    while shelves.height > side_limit && 2 * width <= side_limit {
        width *= 2;
        shelves = Shelves::new(charts, &order, width);
    }
    check(charts.len(), [width, shelves.height], limits)?;
    let places = shelves.places.into_iter().map(|place| place.map(|at| at as u32)).collect();
    Ok(Atlas { size: [width, shelves.height].map(|side| side as u32), places })
}

struct Shelves {
    places: Vec<[u64; 2]>,
    height: u64,
}

impl Shelves {
    fn new(charts: &[[u32; 2]], order: &[usize], width: u64) -> Self {
        let mut places = vec![[0; 2]; charts.len()];
        let (mut at, mut shelf_height) = ([0u64; 2], 0);
        for &chart in order {
            let size = charts[chart].map(u64::from);
            if at[0] + size[0] > width {
                at = [0, at[1] + shelf_height];
                shelf_height = 0;
            }
            places[chart] = at;
            at[0] += size[0];
            shelf_height = shelf_height.max(size[1]);
        }
        Self { places, height: at[1] + shelf_height }
    }
}

fn check(chart_count: usize, [width, height]: [u64; 2], limits: &Limits) -> Result<()> {
    let over = |name: &str, limit: u64, actual: u64| {
        let detail = format!(
            "the {chart_count} faces need an image of {width}x{height}, {} pixels (twice as many along each side as they \
             have texels); the limit is {limit} (limit `{name}`)",
            width * height
        );
        Err(Error::new(ErrorCode::ImageTooLarge, detail).limit(limit, actual))
    };
    let side = width.max(height);
    if side > u64::from(limits.image_side) {
        return over("image_side", limits.image_side.into(), side);
    }
    if width * height > limits.image_pixels {
        return over("image_pixels", limits.image_pixels, width * height);
    }
    Ok(())
}
