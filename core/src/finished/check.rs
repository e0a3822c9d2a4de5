//! What indexed coordinates have to hold before anything is read by them.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::{
    Anchor, BLOCK_ATTRIBUTE, BlockTable, Coordinates, EXTENSION, Finished, FinishedPrimitive,
    FinishedTriangle, LOCAL_ATTRIBUTE,
};
use crate::error::{Error, Result};

/// The largest resolution exponent.
pub const EXPONENT_MAX: u8 = 20;
/// Whole numbers below are exact in 32-bit floats.
pub const NUMBER_END: u32 = 1 << 24;
/// More than there are shapes of blocks; a table of as many is still no burden.
pub const CLASS_COUNT_MAX: usize = 4096;
/// No block is as large, and products of these stay far from 64 bits.
pub const CLASS_SIZE_MAX: u32 = 65_535;

/// A broken rule, and where it is broken below a primitive's JSON pointer.
struct Broken {
    below: String,
    rule: String,
}

impl Finished {
    /// Checks that all primitives of a material have the same coordinates, and that every block that
    /// they name lies inside of the image of every level.
    ///
    /// # Errors
    /// `InvalidModel` with the primitive and the rule: anchors of the other kind, a table without classes or with too
    /// many, exponents over 20, cells or columns of 0, a gap of 0, a shift that reaches into the next block, levels
    /// that are not those of the textures, a class that is not there, a number of 2^24 or more, a local coordinate
    /// outside of its block, a block outside of its level.
    pub fn check_coordinates(&self) -> Result<()> {
        let mut known: BTreeMap<(usize, usize), &Coordinates> = BTreeMap::new();
        for piece in &self.primitives {
            let at = |broken: Broken| {
                let Broken { below, rule } = broken;
                Error::invalid(rule)
                    .at(format!("/meshes/{}/primitives/{}{below}", piece.mesh, piece.primitive))
            };
            if !is_same(
                known.entry((piece.material, piece.part)).or_insert(&piece.coordinates),
                &piece.coordinates,
            ) {
                let rule =
                    "all primitives of one material and part have to have the same coordinates".to_owned();
                return Err(at(Broken { below: table_place(), rule }));
            }
            let Some(texture) =
                self.textures.iter().find(|texture| texture.is_of(piece.material, piece.part))
            else {
                continue;
            };
            let sizes: Vec<[u32; 2]> = texture.levels.iter().map(|image| image.size()).collect();
            check_piece(piece, &sizes).map_err(at)?;
        }
        Ok(())
    }
}

/// Tables that are shared are the same without a look.
fn is_same(one: &Coordinates, other: &Coordinates) -> bool {
    match (one.table(), other.table()) {
        (Some(one), Some(other)) => Arc::ptr_eq(one, other) || one == other,
        (one, other) => one.is_none() && other.is_none(),
    }
}

fn table_place() -> String {
    format!("/extensions/{EXTENSION}/coordinates")
}

fn check_piece(piece: &FinishedPrimitive, sizes: &[[u32; 2]]) -> std::result::Result<(), Broken> {
    if let Some(number) = piece.triangles.iter().position(|t| !piece.coordinates.fits(t.anchor)) {
        let rule = format!("triangle {number} has coordinates of the other kind");
        return Err(Broken { below: String::new(), rule });
    }
    let Coordinates::Indexed(table) = &piece.coordinates else { return Ok(()) };
    check_table(table, sizes)?;
    // By class: one past the largest number that is in use.
    let mut ends = vec![0; table.classes.len()];
    for (number, triangle) in piece.triangles.iter().enumerate() {
        check_triangle(table, triangle, &mut ends).map_err(|(attribute, rule)| Broken {
            below: format!("/attributes/{attribute}"),
            rule: format!("triangle {number}: {rule}"),
        })?;
    }
    check_inside(table, &ends, sizes)
}

fn check_table(table: &BlockTable, sizes: &[[u32; 2]]) -> std::result::Result<(), Broken> {
    let place = table_place();
    let lie = |below: &str, rule: String| Err(Broken { below: format!("{place}{below}"), rule });
    let class_count = table.classes.len();
    if !(1..=CLASS_COUNT_MAX).contains(&class_count) {
        return lie("/classes", format!("there have to be 1 to {CLASS_COUNT_MAX} classes"));
    }
    for (number, class) in table.classes.iter().enumerate() {
        let at = format!("/classes/{number}");
        if class.exponents.iter().any(|&exponent| exponent > EXPONENT_MAX) {
            return lie(&at, format!("\"r\" and \"s\" have to be 0 to {EXPONENT_MAX}"));
        }
        for (name, pair) in [("cells", class.cells), ("gap", class.gap)] {
            if !pair.iter().all(|size| (1..=CLASS_SIZE_MAX).contains(size)) {
                return lie(&at, format!("\"{name}\" has to be 1 to {CLASS_SIZE_MAX} along both axes"));
            }
        }
        if (0..2).any(|k| class.shift[k] >= class.gap[k]) {
            return lie(&at, "\"shift\" has to be below \"gap\" along both axes".to_owned());
        }
    }
    if table.levels.len() != sizes.len() {
        let (found, wanted) = (table.levels.len(), sizes.len());
        return lie(
            "/levels",
            format!("there are {found} levels, and the material's textures have {wanted}"),
        );
    }
    for (level, own) in table.levels.iter().enumerate() {
        let at = format!("/levels/{level}");
        if [own.columns.len(), own.firsts.len(), own.origins.len()] != [class_count; 3] {
            return lie(
                &at,
                format!(
                    "\"columns\", \"first\" and \"origin\" have to have one entry for each of {class_count} classes"
                ),
            );
        }
        if own.firsts.iter().any(|&first| first >= NUMBER_END) {
            return lie(&at, format!("\"first\" has to be below {NUMBER_END}"));
        }
        if own.columns.contains(&0) {
            return lie(&at, "\"columns\" have to be at least 1".to_owned());
        }
    }
    Ok(())
}

/// Of an error, the attribute that it is about.
fn check_triangle(
    table: &BlockTable,
    triangle: &FinishedTriangle,
    ends: &mut [u32],
) -> std::result::Result<(), (&'static str, String)> {
    let Anchor::Block { class, number } = triangle.anchor else { return Ok(()) };
    let (Some(of), Some(end)) = (table.classes.get(class as usize), ends.get_mut(class as usize)) else {
        let count = table.classes.len();
        return Err((BLOCK_ATTRIBUTE, format!("there is no class {class}, the table has {count}")));
    };
    if number >= NUMBER_END {
        return Err((BLOCK_ATTRIBUTE, format!("block numbers have to be below {NUMBER_END}")));
    }
    *end = (*end).max(number + 1);
    let is_inside = |k: usize, local: f32| (0.0..=of.cells[k] as f32).contains(&local);
    if triangle.corners.iter().any(|corner| !is_inside(0, corner.x) || !is_inside(1, corner.y)) {
        let [columns, rows] = of.cells;
        return Err((
            LOCAL_ATTRIBUTE,
            format!("every value has to be within the block's {columns} by {rows} faces"),
        ));
    }
    Ok(())
}

/// Whether the blocks up to the largest number in use lie inside, with their last texels.
fn check_inside(table: &BlockTable, ends: &[u32], sizes: &[[u32; 2]]) -> std::result::Result<(), Broken> {
    for (level, (own, size)) in table.levels.iter().zip(sizes).enumerate() {
        for (class, (of, &end)) in
            table.classes.iter().zip(ends).enumerate().filter(|(_, (_, end))| **end > 0)
        {
            let columns = own.columns[class];
            // The blocks furthest to the right, and furthest down.
            let to_last_column = columns - 1 - own.firsts[class] % columns;
            let [last_column, last_row] = [(end - 1).min(to_last_column), end - 1];
            let texels = [last_column, last_row].map(|number| table.first_texel(class as u32, number, level));
            let segments = of.segments(level);
            let is_outside = |k: usize| {
                let last = texels[k].map(|first| first[k] + u64::from(of.cells[k]) * segments[k]);
                last.is_none_or(|last| last >= u64::from(size[k]))
            };
            if is_outside(0) || is_outside(1) {
                let [width, height] = size;
                let rule = format!(
                    "of class {class}, block {} leaves the image of level {level}, which has {width} × {height} texels",
                    if is_outside(0) { last_column } else { last_row }
                );
                return Err(Broken { below: format!("{}/levels/{level}", table_place()), rule });
            }
        }
    }
    Ok(())
}
