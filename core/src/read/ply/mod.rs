//! PLY to an asset: text, or bytes of either order. Of its elements `vertex` and `face` are read, of their properties those
//! with usual names; all else is skipped.
//!
//! The header's counts are held against the file's length and the limits before memory is taken for them.

mod faces;
mod header;
mod values;
mod vertices;

use super::Context;
use super::made_up::{Coordinates, ImageFiles, Soup, asset, meshes, plain};
use super::text::{file_label, quoted_bytes};
use crate::asset::{AlphaMode, Asset, Material, Slot, TextureRef, UvTransform};
use crate::error::{Error, ErrorCode, Result};
use crate::image::{Wrap, WrapMode};
use crate::watch;

use header::{Element, Header};
use values::Values;

/// Elements between two looks at the watch.
const WATCH_ELEMENTS: u64 = 1 << 16;

/// `main` is the file's path in the upload, for error messages and as the name of the mesh.
pub(super) fn read(bytes: &[u8], main: &str, context: &mut Context) -> Result<Asset> {
    let file = file_label(main);
    let mut header = header::parse(bytes, &file)?;
    let mut soup = Soup { file, separator: ", face ", ..Soup::default() };
    read_body(bytes, &header, &mut soup, context)?;
    if soup.polygons.is_empty() {
        let detail = "the PLY file has no faces; points alone have no surface to store colors on";
        return Err(Error::new(ErrorCode::NothingToConvert, detail).at(soup.file));
    }
    if soup.texcoords.is_empty() && !header.textures.is_empty() {
        let detail = "textures in a file without texture coordinates; they were left out";
        context.warnings.add_many("unused_texture", &soup.file, detail, header.textures.len() as u64);
        header.textures.clear();
        soup.polygons.iter_mut().for_each(|polygon| polygon.material = 0);
    }
    let mut files = ImageFiles::default();
    let materials = materials(&header, &soup, &mut files, context)?;
    let meshes = meshes(&soup, &[Vec::new()], &Coordinates::default(), context)?;
    asset(meshes, materials, files, context)
}

fn read_body(bytes: &[u8], header: &Header, soup: &mut Soup, context: &mut Context) -> Result<()> {
    let mut values = Values::new(&bytes[header.body..], header.encoding);
    let mut seen = [false; 2];
    for element in &header.elements {
        values.check_room(element).map_err(|error| error.at(soup.file.clone()))?;
        let known = [&b"vertex"[..], b"face"].into_iter().position(|name| name == element.name);
        let Some(known) = known else {
            skip(element, &mut values, context).map_err(|error| {
                error.at(format!("{}, element {}", soup.file, quoted_bytes(&element.name)))
            })?;
            continue;
        };
        if seen[known] || known == 1 && !seen[0] {
            let detail = "an element `vertex` and then an element `face` are understood, one of each";
            return Err(Error::invalid(detail).at(soup.file.clone()));
        }
        seen[known] = true;
        match known {
            0 => vertices::read(element, &mut values, soup, context)?,
            _ => faces::read(element, &mut values, header.textures.len(), soup, context)?,
        }
    }
    Ok(())
}

fn skip(element: &Element, values: &mut Values, context: &Context) -> Result<()> {
    if element.properties.is_empty() {
        return Ok(());
    }
    for number in 0..element.count {
        if number % WATCH_ELEMENTS == 0 {
            watch::check(context.watch)?;
        }
        for property in &element.properties {
            let count = match property.length {
                Some(length) => values.length(length, property.kind)?,
                None => 1,
            };
            values.skip(property.kind, count)?;
        }
    }
    Ok(())
}

/// One for each texture, and one without where a face shows none.
fn materials(
    header: &Header,
    soup: &Soup,
    files: &mut ImageFiles,
    context: &mut Context,
) -> Result<Vec<Material>> {
    let folder = context.resources.folder().to_owned();
    let mut materials = Vec::with_capacity(header.textures.len() + 1);
    for (name, line) in &header.textures {
        let image = files.number(name, &folder, &format!("{}:{line}", soup.file), context)?;
        let wrap = Wrap { s: WrapMode::Repeat, t: WrapMode::Repeat };
        let mut material = plain(name);
        material.slots.insert(
            Slot::BaseColor,
            TextureRef { image, wrap, texcoord: 0, transform: UvTransform::default() },
        );
        materials.push(material);
    }
    if soup.polygons.iter().any(|polygon| polygon.material as usize == materials.len()) {
        materials.push(plain(b""));
    }
    if soup.has_alpha {
        materials.iter_mut().for_each(|material| material.alpha_mode = AlphaMode::Blend);
    }
    Ok(materials)
}
