//! The element `face`: polygons, with texture coordinates of their own where a program wrote any.

use super::super::Context;
use super::super::made_up::{Corner, NONE, Polygon, Soup};
use super::WATCH_ELEMENTS;
use super::header::Element;
use super::values::Values;
use super::vertices::texcoord;
use crate::error::{Error, Result};
use crate::watch;

/// What is read of one face; buffers that go from face to face.
#[derive(Default)]
struct Row {
    vertices: Vec<u32>,
    /// Two for each corner, or none.
    texcoords: Vec<f64>,
    /// Which of the file's textures it shows; a negative number stands for none.
    texture: f64,
}

struct Form {
    vertices: usize,
    texcoords: Option<usize>,
    texture: Option<usize>,
}

/// Appends polygons. Those that show texture `n` have the material `n`, those that show none `texture_count`.
pub fn read(
    element: &Element,
    values: &mut Values,
    texture_count: usize,
    soup: &mut Soup,
    context: &mut Context,
) -> Result<()> {
    let Some(vertices) = element.list(&["vertex_indices", "vertex_index"]) else {
        let detail = "the element `face` has no list `vertex_indices`";
        return Err(Error::invalid(detail).at(soup.file.clone()));
    };
    let form = Form {
        vertices,
        texcoords: element.list(&["texcoord"]),
        texture: element.scalar(&["texnumber"]).filter(|_| texture_count > 0),
    };
    // Those of vertices, which corners without their own have by the same number.
    let vertex_texcoords = soup.texcoords.len();
    let mut row = Row::default();
    for number in 0..element.count {
        if number % WATCH_ELEMENTS == 0 {
            watch::check(context.watch)?;
        }
        let place = |error: Error| error.at(format!("{}, face {number}", soup.file));
        form.read_row(element, values, soup.positions.len(), &mut row).map_err(place)?;
        let count = row.vertices.len();
        context.budget.take_triangles(count as u64 - 2, "").map_err(place)?;
        let material = material(row.texture, texture_count).map_err(place)?;
        let first_texcoord = soup.texcoords.len() as u64;
        let own = row.texcoords.chunks_exact(2).map(|stored| texcoord([stored[0], stored[1]]));
        let own = own.collect::<Result<Vec<_>>>().map_err(place)?;
        let first = soup.corners.len();
        for (corner, &vertex) in (0u64..).zip(&row.vertices) {
            let texcoord = match own.is_empty() {
                false => u32::try_from(first_texcoord + corner).ok().filter(|&own| own != NONE),
                true => Some(if (vertex as usize) < vertex_texcoords { vertex } else { NONE }),
            };
            let texcoord = texcoord
                .ok_or_else(|| place(Error::invalid("more texture coordinates than 32 bits can name")))?;
            let normal = if soup.normals.is_empty() { NONE } else { vertex };
            soup.corners.push(Corner { position: vertex, texcoord, normal });
        }
        soup.texcoords.extend(own);
        soup.polygons.push(Polygon { first, count, object: 0, material, number: number as usize });
    }
    Ok(())
}

fn material(texture: f64, texture_count: usize) -> Result<u32> {
    if texture < 0.0 {
        return Ok(texture_count as u32);
    }
    if texture.fract() == 0.0 && (texture as usize) < texture_count.max(1) {
        return Ok(texture as u32);
    }
    Err(Error::invalid(format!("`texnumber` is {texture}; the header names {texture_count} textures")))
}

impl Form {
    /// Reads a face of at least three corners.
    fn read_row(
        &self,
        element: &Element,
        values: &mut Values,
        vertex_count: usize,
        row: &mut Row,
    ) -> Result<()> {
        row.vertices.clear();
        row.texcoords.clear();
        row.texture = 0.0;
        for (number, property) in element.properties.iter().enumerate() {
            let kind = property.kind;
            let Some(length) = property.length else {
                match self.texture == Some(number) {
                    true => row.texture = values.number(kind)?,
                    false => values.skip(kind, 1)?,
                }
                continue;
            };
            let count = values.length(length, kind)?;
            if number == self.vertices {
                for _ in 0..count {
                    row.vertices.push(vertex(values.number(kind)?, vertex_count)?);
                }
            } else if self.texcoords == Some(number) {
                for _ in 0..count {
                    row.texcoords.push(values.number(kind)?);
                }
            } else {
                values.skip(kind, count)?;
            }
        }
        let (corners, numbers) = (row.vertices.len(), row.texcoords.len());
        if corners < 3 {
            return Err(Error::invalid(format!("the face has {corners} corners; it needs at least 3")));
        }
        if numbers != 0 && numbers != 2 * corners {
            let detail =
                format!("`texcoord` has {numbers} numbers for {corners} corners; it needs two for each");
            return Err(Error::invalid(detail));
        }
        Ok(())
    }
}

fn vertex(number: f64, vertex_count: usize) -> Result<u32> {
    if number >= 0.0 && number < vertex_count as f64 && number.fract() == 0.0 {
        return Ok(number as u32);
    }
    Err(Error::invalid(format!("the vertex index {number} is out of range: the file has {vertex_count}")))
}
