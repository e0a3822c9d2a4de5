//! What the bundle takes from the shaders crate: the text of the sampling functions and the picture.
//! Nothing else in this crate touches it.

use meshcolor::finished::Finished;
use meshcolor::pipeline::Conversion;
use meshcolor::write::BundleFile;
pub use meshcolor_shaders::preview::Sheet;

/// Draws the sheet of a conversion, under the name of the model's file.
///
/// # Errors
/// Whatever kept the renderer from drawing; a conversion is complete without its picture.
pub fn draw(conversion: &Conversion, title: &str) -> anyhow::Result<Sheet> {
    Ok(meshcolor_shaders::preview::sheet_titled(conversion, title)?)
}

/// The font that pictures are set in.
pub const FONT: &[u8] = meshcolor_shaders::FONT;

/// The sampling functions that users paste into their shaders, as far as the coordinates of a conversion
/// need them.
pub fn shaders(finished: &Finished) -> Vec<BundleFile> {
    let file = |name: &str, text: &str| BundleFile {
        path: format!("shaders/{name}.wgsl"),
        bytes: text.as_bytes().to_vec(),
    };
    let mut files = vec![file("mesh_color_texture", meshcolor_shaders::WGSL)];
    if finished.primitives.iter().any(|primitive| primitive.coordinates.table().is_some()) {
        files.push(file("mesh_color_texture_indexed", meshcolor_shaders::WGSL_INDEXED));
    }
    files
}

#[cfg(test)]
mod tests {
    use meshcolor::finished::{Coordinates, FinishedPrimitive};

    use super::*;

    #[test]
    fn a_bundle_has_the_functions_that_its_coordinates_need() {
        let paths = |coordinates: Coordinates| -> Vec<String> {
            let primitive = FinishedPrimitive {
                mesh: 0,
                primitive: 0,
                material: 0,
                part: 0,
                coordinates,
                triangles: Vec::new(),
                frames: Vec::new(),
                cuts: Vec::new(),
            };
            let finished = Finished { primitives: vec![primitive], ..Finished::default() };
            shaders(&finished).into_iter().map(|file| file.path).collect()
        };
        let [four_d, indexed] =
            ["shaders/mesh_color_texture.wgsl", "shaders/mesh_color_texture_indexed.wgsl"];
        assert_eq!(paths(Coordinates::Scaled), [four_d]);
        assert_eq!(paths(Coordinates::Indexed(Default::default())), [four_d, indexed]);
    }
}
