//! One primitive: converted, or as the source has it.

use glam::{Vec2, Vec4};
use serde_json::{Map, Value};

use crate::asset::{Asset, Attribute, Primitive};
use crate::error::{Error, Result, Warning};
use crate::finished::{Coordinates, EXTENSION, Finished, FinishedPrimitive};

use super::alike::{self, Kept};
use super::coordinates;
use super::draft::{Draft, index, member, remove_extension};
use super::materials::{Converted, Materials, variants};
use super::vertices::{self, Corners};

/// glTF's mode for loose points.
const POINTS: u32 = 0;

/// Which primitive to write.
pub struct Target<'a> {
    pub asset: &'a Asset,
    pub finished: &'a Finished,
    pub mesh: usize,
    pub primitive: usize,
}

impl Target<'_> {
    fn source(&self) -> &Primitive {
        &self.asset.meshes[self.mesh].primitives[self.primitive]
    }

    fn place(&self) -> String {
        format!("/meshes/{}/primitives/{}", self.mesh, self.primitive)
    }

    /// Replaces geometry and coordinates by the converted ones; everything else in the primitive stays. Returns
    /// the number of vertices.
    pub fn write_converted(
        &self,
        draft: &mut Draft<'_>,
        materials: &mut Materials,
        piece: &FinishedPrimitive,
    ) -> Result<usize> {
        let converted = materials.converted(piece.material).ok_or_else(|| {
            Error::internal("a converted primitive's material has no converted texture").at(self.place())
        })?;
        let framed = !piece.frames.is_empty();
        let kept =
            Kept { normals: !framed, tangents: !framed && converted.keeps_tangents, sets: &converted.sets };
        let corners = Corners::distinct(piece, &alike::firsts(self.source(), &kept));
        let attributes = self.converted_attributes(draft, converted, &corners, &piece.coordinates);
        let targets = self.targets(draft, converted, &corners);
        let indices = vertices::add_indices(draft, &corners.indices, corners.corners.len());
        let cuts = self.cuts(draft, piece)?;

        let json = draft.primitive(self.mesh, self.primitive);
        for replaced in ["attributes", "indices", "targets", "mode"] {
            json.remove(replaced);
        }
        remove_extension(json, "KHR_draco_mesh_compression");
        remove_extension(json, EXTENSION);
        json.insert("attributes".to_owned(), Value::Object(attributes));
        json.insert("indices".to_owned(), indices.into());
        json.insert("material".to_owned(), piece.material.into());
        if !targets.is_empty() {
            json.insert("targets".to_owned(), Value::Array(targets));
        }
        let mut own = Map::new();
        if !cuts.is_empty() {
            own.insert("cuts".to_owned(), Value::Object(cuts));
        }
        if let Coordinates::Indexed(table) = &piece.coordinates {
            own.insert("coordinates".to_owned(), coordinates::table(table));
        }
        if !own.is_empty() {
            member(json, "extensions").insert(EXTENSION.to_owned(), Value::Object(own));
        }
        self.move_materials(draft, |draft, material| {
            if material == piece.material {
                material
            } else {
                materials.copy(draft, material, Some(piece.material))
            }
        });
        Ok(corners.corners.len())
    }

    /// Leaves a glTF primitive as it is; one of a made-up document gets its data.
    pub fn write_source(&self, draft: &mut Draft<'_>, materials: &mut Materials) -> Result<()> {
        let json = draft.primitive(self.mesh, self.primitive);
        let has_data = json.get("attributes").and_then(Value::as_object).is_some_and(|all| !all.is_empty());
        if !has_data {
            self.write_data(draft)?;
        }
        self.move_materials(draft, |draft, material| {
            if materials.converted(material).is_some() {
                materials.copy(draft, material, None)
            } else {
                material
            }
        });
        Ok(())
    }

    fn write_data(&self, draft: &mut Draft<'_>) -> Result<()> {
        let source = self.source();
        let vertex_count = source.positions.len();
        if vertex_count == 0 {
            return Err(Error::internal("a primitive has no vertices").at(self.place()));
        }
        let vertices: Vec<u32> = (0..vertex_count as u32).collect();
        let mut attributes = Map::new();
        let mut add = |name: &str, accessor: usize| attributes.insert(name.to_owned(), accessor.into());
        add("POSITION", vertices::add_positions(draft, &source.positions));
        if !source.normals.is_empty() {
            add("NORMAL", vertices::add_floats(draft, &arrays(&source.normals)));
        }
        if !source.tangents.is_empty() {
            add("TANGENT", vertices::add_floats(draft, &arrays(&source.tangents)));
        }
        for (set, values) in source.texcoords.iter().enumerate().filter(|(_, values)| !values.is_empty()) {
            add(&format!("TEXCOORD_{set}"), vertices::add_floats(draft, &arrays(values)));
        }
        for attribute in passed_on(source) {
            add(&attribute.semantic, vertices::add_attribute(draft, attribute, &vertices));
        }
        let triangles = source.faces.iter().flat_map(|face| {
            let corners = face.corners;
            face.triangles().iter().flatten().map(move |corner| corners[*corner])
        });
        let triangles: Vec<u32> = triangles.collect();
        let indices = (!triangles.is_empty()).then(|| vertices::add_indices(draft, &triangles, vertex_count));
        let json = draft.primitive(self.mesh, self.primitive);
        json.insert("attributes".to_owned(), Value::Object(attributes));
        match indices {
            Some(indices) => json.insert("indices".to_owned(), indices.into()),
            None => json.insert("mode".to_owned(), POINTS.into()),
        };
        if let Some(material) = source.material {
            json.insert("material".to_owned(), material.into());
        }
        Ok(())
    }

    fn converted_attributes(
        &self,
        draft: &mut Draft<'_>,
        converted: &Converted,
        corners: &Corners,
        coordinates: &Coordinates,
    ) -> Map<String, Value> {
        let source = self.source();
        let vertices = corners.vertices();
        let frames: Option<Vec<_>> = corners.corners.iter().map(|corner| corner.frame).collect();
        let mut attributes = Map::new();
        let mut add = |name: &str, accessor: usize| attributes.insert(name.to_owned(), accessor.into());
        add("POSITION", vertices::add_positions(draft, &pick(&source.positions, &vertices)));
        match frames {
            Some(frames) => {
                let normals: Vec<_> = frames.iter().map(|frame| frame.normal.to_array()).collect();
                let tangents: Vec<_> = frames.iter().map(|frame| frame.tangent.to_array()).collect();
                add("NORMAL", vertices::add_floats(draft, &normals));
                add("TANGENT", vertices::add_floats(draft, &tangents));
            }
            None => {
                if !source.normals.is_empty() {
                    let normals = pick(&source.normals, &vertices);
                    add("NORMAL", vertices::add_floats(draft, &arrays(&normals)));
                }
                if !source.tangents.is_empty() && converted.keeps_tangents {
                    let tangents: Vec<Vec4> = pick(&source.tangents, &vertices);
                    add("TANGENT", vertices::add_floats(draft, &arrays(&tangents)));
                }
            }
        }
        let places = coordinates::texcoords(coordinates, &corners.corners, converted.size);
        add("TEXCOORD_0", vertices::add_floats(draft, &places));
        for (place, set) in converted.sets.iter().enumerate() {
            // A set that the primitive lacks reads (0, 0), but the sets behind it need it in the file.
            let values = match source.texcoords.get(*set).filter(|values| !values.is_empty()) {
                Some(values) => pick(values, &vertices),
                None => vec![Vec2::ZERO; vertices.len()],
            };
            add(&format!("TEXCOORD_{}", place + 1), vertices::add_floats(draft, &arrays(&values)));
        }
        for attribute in passed_on(source) {
            add(&attribute.semantic, vertices::add_attribute(draft, attribute, &vertices));
        }
        coordinates::add(draft, &corners.corners, &mut attributes);
        attributes
    }

    fn targets(&self, draft: &mut Draft<'_>, converted: &Converted, corners: &Corners) -> Vec<Value> {
        let vertices = corners.vertices();
        let framed = corners.corners.first().is_some_and(|corner| corner.frame.is_some());
        let source = self.source();
        let mut targets = Vec::with_capacity(source.targets.len());
        for target in &source.targets {
            let mut json = Map::new();
            for attribute in &target.attributes {
                let keeps_tangents = !framed && converted.keeps_tangents;
                let Some(name) = target_name(attribute, &converted.sets, keeps_tangents) else { continue };
                let accessor = vertices::add_attribute(draft, attribute, &vertices);
                json.insert(name, accessor.into());
            }
            if json.is_empty() {
                // glTF has no empty target, and weights count on its place in the row.
                let zeros = vertices::add_zero_positions(draft, vertices.len());
                json.insert("POSITION".to_owned(), zeros.into());
            }
            targets.push(Value::Object(json));
        }
        targets
    }

    fn cuts(&self, draft: &mut Draft<'_>, piece: &FinishedPrimitive) -> Result<Map<String, Value>> {
        let mut cuts = Map::new();
        for cut in piece.cuts.iter().filter(|cut| cut.bits.iter().any(|bits| *bits != 0)) {
            let texture = self.finished.textures.get(cut.texture);
            let texture = texture.filter(|texture| {
                texture.is_of(piece.material, piece.part) && cut.bits.len() == piece.triangles.len()
            });
            let texture = texture.ok_or_else(|| {
                Error::internal("cuts do not fit their primitive's material and triangles").at(self.place())
            })?;
            let accessor = vertices::add_bytes(draft, &cut.bits);
            for slot in &texture.slots {
                cuts.insert(slot.gltf_name().to_owned(), accessor.into());
            }
        }
        Ok(cuts)
    }

    /// Changes every material that the primitive names, variants too.
    fn move_materials<'d>(
        &self,
        draft: &mut Draft<'d>,
        mut moved: impl FnMut(&mut Draft<'d>, usize) -> usize,
    ) {
        let json = draft.primitive(self.mesh, self.primitive);
        let own = json.get("material").and_then(Value::as_u64).map(|own| own as usize);
        let mapped = variants(json);
        let own = own.map(|own| moved(draft, own));
        let mut mapped =
            mapped.into_iter().map(|variant| moved(draft, variant)).collect::<Vec<_>>().into_iter();
        let json = draft.primitive(self.mesh, self.primitive);
        if let Some(own) = own {
            json.insert("material".to_owned(), own.into());
        }
        let mappings = json
            .get_mut("extensions")
            .and_then(|extensions| extensions.get_mut("KHR_materials_variants")?.get_mut("mappings"))
            .and_then(Value::as_array_mut);
        for mapping in mappings.into_iter().flatten().filter(|mapping| index(mapping, "material").is_some()) {
            if let Some(variant) = mapped.next() {
                mapping["material"] = variant.into();
            }
        }
    }
}

/// See [`super::losses`].
pub fn losses(asset: &Asset, finished: &Finished) -> Vec<Warning> {
    let mut warning: Option<Warning> = None;
    for piece in finished.primitives.iter().filter(|piece| !piece.frames.is_empty()) {
        let source = asset.meshes.get(piece.mesh).and_then(|mesh| mesh.primitives.get(piece.primitive));
        let has_tangents = source.is_some_and(|source| {
            source.targets.iter().flat_map(|target| &target.attributes).any(|a| a.semantic == "TANGENT")
        });
        if !has_tangents {
            continue;
        }
        let blank = Warning {
            code: "morph_tangents_dropped".to_owned(),
            detail:
                "the tangents of morph targets belong to the source's tangent frames, which the converted \
                     normal map replaces; the targets keep positions and normals"
                    .to_owned(),
            pointer: format!("/meshes/{}/primitives/{}", piece.mesh, piece.primitive),
            count: 0,
        };
        warning.get_or_insert(blank).count += 1;
    }
    warning.into_iter().collect()
}

/// Attributes that are copied vertex by vertex; an earlier conversion's coordinates are not.
fn passed_on(source: &Primitive) -> impl Iterator<Item = &Attribute> {
    source.attributes.iter().filter(|attribute| !attribute.semantic.starts_with("_MCT_"))
}

/// The name of a morph target's attribute in the file, or `None` where what it moves was replaced.
fn target_name(attribute: &Attribute, sets: &[usize], keeps_tangents: bool) -> Option<String> {
    match attribute.semantic.strip_prefix("TEXCOORD_") {
        Some(set) => {
            let set: usize = set.parse().ok()?;
            let place = sets.iter().position(|own| *own == set)?;
            Some(format!("TEXCOORD_{}", place + 1))
        }
        None if attribute.semantic == "TANGENT" && !keeps_tangents => None,
        None => Some(attribute.semantic.clone()),
    }
}

fn pick<T: Copy>(values: &[T], vertices: &[u32]) -> Vec<T> {
    vertices.iter().map(|vertex| values[*vertex as usize]).collect()
}

fn arrays<T: Copy + Into<[f32; N]>, const N: usize>(values: &[T]) -> Vec<[f32; N]> {
    values.iter().map(|value| (*value).into()).collect()
}
