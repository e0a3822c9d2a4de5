//! One primitive: converted, or as the source has it.

use serde_json::{Map, Value};

use crate::asset::{Asset, MESH_COLORS_EXTENSION, NGON_EXTENSION, Primitive};
use crate::error::{Error, Result, Warning};
use crate::finished::{Coordinates, EXTENSION, Finished};

use super::coordinates;
use super::draft::{Draft, index, member, remove_extension};
use super::geometry::{Geometry, Member, arrays, passed_on};
use super::materials::{Materials, variants};
use super::vertices;

/// glTF's mode for loose points.
const POINTS: u32 = 0;

/// Which primitive to write.
pub struct Target<'a> {
    pub asset: &'a Asset,
    pub finished: &'a Finished,
    pub mesh: usize,
    pub primitive: usize,
}

/// What is written in one primitive.
pub struct Group<'a> {
    /// At least one; all fit.
    pub members: Vec<Member<'a>>,
    /// What the first one's primitive has besides its geometry.
    pub rest: Map<String, Value>,
}

impl<'a> Group<'a> {
    /// Whether a member can join: nothing but geometry differs. A primitive with variants stays alone.
    pub fn takes(&self, other: &Member<'a>, rest: &Map<String, Value>) -> bool {
        let Some(first) = self.members.first() else { return false };
        let but_material = |rest: &Map<String, Value>| {
            let mut rest = rest.clone();
            rest.remove("material");
            rest
        };
        first.fits(other) && variants(rest).is_empty() && but_material(&self.rest) == but_material(rest)
    }
}

/// All of a primitive but its geometry.
pub fn rest_of(primitive: &Map<String, Value>) -> Map<String, Value> {
    let mut rest = primitive.clone();
    for replaced in ["attributes", "indices", "targets", "mode"] {
        rest.remove(replaced);
    }
    remove_extension(&mut rest, "KHR_draco_mesh_compression");
    remove_extension(&mut rest, EXTENSION);
    remove_extension(&mut rest, MESH_COLORS_EXTENSION);
    rest
}

impl Target<'_> {
    fn place(&self) -> String {
        place_of(self.mesh, self.primitive)
    }

    /// Puts a converted primitive at `slot` of the mesh: geometry and coordinates are new, everything else is the
    /// source's. Returns the number of vertices.
    pub fn write_converted(
        &self,
        draft: &mut Draft<'_>,
        materials: &mut Materials,
        group: &Group<'_>,
        slot: usize,
    ) -> Result<usize> {
        let Some(Member { piece, converted, .. }) = group.members.first() else {
            return Err(Error::internal("nothing stands in a primitive").at(self.place()));
        };
        let geometry = Geometry::new(&group.members);
        let attributes = geometry.add_attributes(draft);
        let targets = geometry.add_targets(draft);
        let indices = geometry.add_indices(draft);
        let cuts = geometry.add_cuts(draft, self.finished).map_err(|error| error.at(self.place()))?;

        let json = draft.primitive(self.mesh, slot);
        json.clone_from(&group.rest);
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
        let number = converted.number;
        if !geometry.keeps_polygons() {
            remove_extension(json, NGON_EXTENSION);
        }
        self.move_materials(slot, draft, |draft, material| {
            if material == piece.material {
                number
            } else {
                materials.copy(draft, material, Some(piece.material))
            }
        });
        Ok(geometry.vertex_count())
    }

    /// Leaves a glTF primitive as it is; one of a made-up document gets its data.
    pub fn write_source(&self, draft: &mut Draft<'_>, materials: &mut Materials) -> Result<()> {
        write_data_once(draft, self.asset, [self.mesh, self.primitive])?;
        remove_extension(draft.primitive(self.mesh, self.primitive), MESH_COLORS_EXTENSION);
        self.move_materials(self.primitive, draft, |draft, material| {
            if materials.is_converted(material) { materials.copy(draft, material, None) } else { material }
        });
        Ok(())
    }

    /// Changes every material that the primitive names, variants too.
    fn move_materials<'d>(
        &self,
        slot: usize,
        draft: &mut Draft<'d>,
        mut moved: impl FnMut(&mut Draft<'d>, usize) -> usize,
    ) {
        let json = draft.primitive(self.mesh, slot);
        let own = json.get("material").and_then(Value::as_u64).map(|own| own as usize);
        let mapped = variants(json);
        let own = own.map(|own| moved(draft, own));
        let mut mapped =
            mapped.into_iter().map(|variant| moved(draft, variant)).collect::<Vec<_>>().into_iter();
        let json = draft.primitive(self.mesh, slot);
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

/// Gives a primitive of a made-up document its data; a glTF primitive has them.
pub fn write_data_once(draft: &mut Draft<'_>, asset: &Asset, [mesh, primitive]: [usize; 2]) -> Result<()> {
    let json = draft.primitive(mesh, primitive);
    if json.get("attributes").and_then(Value::as_object).is_some_and(|all| !all.is_empty()) {
        return Ok(());
    }
    write_data(draft, &asset.meshes[mesh].primitives[primitive], [mesh, primitive])
}

fn place_of(mesh: usize, primitive: usize) -> String {
    format!("/meshes/{mesh}/primitives/{primitive}")
}

fn write_data(draft: &mut Draft<'_>, source: &Primitive, [mesh, primitive]: [usize; 2]) -> Result<()> {
    let vertex_count = source.positions.len();
    if vertex_count == 0 {
        return Err(Error::internal("a primitive has no vertices").at(place_of(mesh, primitive)));
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
        if let Some(accessor) = vertices::add_attribute(draft, &[(attribute, &vertices)]) {
            add(&attribute.semantic, accessor);
        }
    }
    let triangles = source.faces.iter().flat_map(|face| {
        let corners = face.corners;
        face.triangles().iter().flatten().map(move |corner| corners[*corner])
    });
    let triangles: Vec<u32> = triangles.collect();
    let indices = (!triangles.is_empty()).then(|| vertices::add_indices(draft, &triangles, vertex_count));
    let targets: Vec<Value> = (source.targets.iter())
        .map(|target| {
            let own = target.attributes.iter();
            own.map(|own| (own.semantic.clone(), vertices::add_whole(draft, own).into())).collect()
        })
        .map(Value::Object)
        .collect();
    let json = draft.primitive(mesh, primitive);
    json.insert("attributes".to_owned(), Value::Object(attributes));
    if !targets.is_empty() {
        json.insert("targets".to_owned(), Value::Array(targets));
    }
    match indices {
        Some(indices) => json.insert("indices".to_owned(), indices.into()),
        None => json.insert("mode".to_owned(), POINTS.into()),
    };
    if let Some(material) = source.material {
        json.insert("material".to_owned(), material.into());
    }
    Ok(())
}

/// See [`super::losses`].
pub fn losses(asset: &Asset, finished: &Finished) -> Vec<Warning> {
    let mut warning: Option<Warning> = None;
    let mut pieces: Vec<_> = finished.primitives.iter().filter(|piece| !piece.frames.is_empty()).collect();
    pieces.dedup_by_key(|piece| (piece.mesh, piece.primitive));
    for piece in pieces {
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
