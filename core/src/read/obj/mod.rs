//! OBJ with MTL to an asset. The parser is our own: one pass, linear time, and no file is opened but
//! through the upload.

mod lines;
mod materials;
mod mtl;
mod parse;
mod ptex;
mod split;

use super::Context;
use super::made_up::{self, NONE, Soup};
use super::text::file_label;
use crate::asset::{Asset, Material};
use crate::error::Result;

/// `main` is the file's path in the upload, for error messages and as the name of an unnamed mesh.
pub(super) fn read(text: &[u8], main: &str, context: &mut Context) -> Result<Asset> {
    let file = file_label(main);
    let mut parsed = parse::parse(text, &file, context)?;
    let (mut materials, mut files, uses) = materials::read(&mut parsed, &file, context)?;
    let coordinates = ptex::read(&mut parsed, &uses, &mut files, context)?;
    if parsed.soup.is_colored() {
        give_material(&mut parsed.soup, &mut materials);
    }
    let meshes = made_up::meshes(&parsed.soup, &parsed.objects.list, &coordinates, context)?;
    made_up::asset(meshes, materials, files, context)
}

/// Faces without a material get a plain one of their own: vertex colors are a picture of a material's.
fn give_material(soup: &mut Soup, materials: &mut Vec<Material>) {
    let number = materials.len() as u32;
    let mut bare = soup.polygons.iter_mut().filter(|polygon| polygon.material == NONE).peekable();
    if bare.peek().is_some() {
        bare.for_each(|polygon| polygon.material = number);
        materials.push(made_up::plain(b""));
    }
}
