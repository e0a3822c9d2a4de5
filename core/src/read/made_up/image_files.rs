//! Image files that materials name, in the order of first use.

use std::collections::{BTreeMap, HashMap};

use super::super::images::Wanted;
use super::super::{Context, images, ptex};
use crate::asset::{EncodedImage, Material};
use crate::error::Result;
use crate::image::Image;

/// Each file once.
#[derive(Default)]
pub struct ImageFiles {
    encoded: Vec<EncodedImage>,
    names: Vec<String>,
    places: Vec<String>,
    numbers: HashMap<(String, Vec<u8>), usize>,
    /// Those that are no pictures, and what was made of them; nothing of those that nobody reads.
    apart: BTreeMap<usize, Option<Image>>,
}

/// By number of the file.
pub struct Loaded {
    pub images: Vec<Image>,
    pub encoded: Vec<EncodedImage>,
    /// File names.
    pub names: Vec<String>,
}

impl ImageFiles {
    /// The number of a file that is named at `place`, relative to `folder`.
    pub fn number(&mut self, name: &[u8], folder: &str, place: &str, context: &mut Context) -> Result<usize> {
        let key = (folder.to_owned(), name.to_vec());
        if let Some(&known) = self.numbers.get(&key) {
            return Ok(known);
        }
        let (path, bytes) = context.resources.load_name(name, folder, place, &mut context.budget)?;
        let is_ptex = ptex::is_ptex(&bytes);
        let media_type = if is_ptex { Some(ptex::MEDIA_TYPE) } else { images::media_type_of(&bytes) };
        let media_type = media_type.unwrap_or("application/octet-stream").to_owned();
        self.encoded.push(EncodedImage { media_type, bytes });
        self.names.push(path);
        self.places.push(place.to_owned());
        let number = self.encoded.len() - 1;
        self.numbers.insert(key, number);
        if is_ptex {
            self.apart.insert(number, None);
        }
        Ok(number)
    }

    /// The number of another image of the same file.
    pub fn copy(&mut self, number: usize) -> usize {
        self.encoded.push(self.encoded[number].clone());
        self.names.push(self.names[number].clone());
        self.places.push(self.places[number].clone());
        let copy = self.encoded.len() - 1;
        if self.is_apart(number) {
            self.apart.insert(copy, None);
        }
        copy
    }

    /// Whether the file is no picture, so that somebody else has to [`put`](Self::put) one in its place.
    pub fn is_apart(&self, number: usize) -> bool {
        self.apart.contains_key(&number)
    }

    pub fn put(&mut self, number: usize, image: Image) {
        self.apart.insert(number, Some(image));
    }

    pub fn bytes(&self, number: usize) -> &[u8] {
        &self.encoded[number].bytes
    }

    /// Where the file is named.
    pub fn place(&self, number: usize) -> &str {
        &self.places[number]
    }

    /// Decodes all, and turns slots to the first of files that are the same.
    pub fn decode(self, materials: &mut [Material], context: &mut Context) -> Result<Loaded> {
        let Self { encoded, names, places, apart, .. } = self;
        let mut wanted = vec![Wanted::Shared; encoded.len()];
        apart.keys().for_each(|number| wanted[*number] = Wanted::No);
        let decoded = images::decode_all(&encoded, &wanted, |index| places[index].clone(), context)?;
        for reference in materials.iter_mut().flat_map(|material| material.slots.values_mut()) {
            if !apart.contains_key(&reference.image) {
                reference.image = decoded.canonical[reference.image];
            }
        }
        let mut images = decoded.images;
        for (number, image) in apart {
            images[number] = image.unwrap_or_else(|| images[number].clone());
        }
        Ok(Loaded { images, encoded, names })
    }
}
