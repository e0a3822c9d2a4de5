//! Vertices, indices, morph targets and cuts of one written primitive: of one converted piece, or of several in a row.

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Map, Value};

use crate::asset::{Attribute, Primitive, VERTEX_COLORS};
use crate::error::{Error, Result};
use crate::finished::{Finished, FinishedPrimitive};

use super::alike::{self, Kept};
use super::coordinates;
use super::draft::Draft;
use super::materials::Converted;
use super::ngons;
use super::vertices::{self, Corner, Corners};

/// A converted piece on its way into the file.
#[derive(Clone)]
pub struct Member<'a> {
    /// Of the asset.
    pub source: &'a Primitive,
    pub piece: &'a FinishedPrimitive,
    pub converted: Converted,
    /// By triangle: sides where another material begins that the file does not tell apart. May be empty.
    pub border: &'a [u8],
}

/// Something that pieces in one primitive have to have in common.
#[derive(PartialEq)]
struct Form<'a> {
    framed: bool,
    normals: bool,
    tangents: bool,
    set_count: usize,
    attributes: Vec<Kind<'a>>,
    targets: Vec<Vec<(String, Kind<'a>)>>,
}

/// Name, component type, type, and whether it is normalized.
type Kind<'a> = (&'a str, u32, &'a str, bool);

fn kind(attribute: &Attribute) -> Kind<'_> {
    (&attribute.semantic, attribute.component_type, &attribute.kind, attribute.normalized)
}

impl<'a> Member<'a> {
    fn is_framed(&self) -> bool {
        !self.piece.frames.is_empty()
    }

    fn keeps_tangents(&self) -> bool {
        !self.is_framed() && self.converted.keeps_tangents
    }

    fn form(&self) -> Form<'_> {
        let targets = self.source.targets.iter().map(|target| {
            let named = target.attributes.iter().map(|own| Some((self.target_name(own)?, kind(own))));
            named.flatten().collect()
        });
        Form {
            framed: self.is_framed(),
            normals: !self.source.normals.is_empty(),
            tangents: self.keeps_tangents() && !self.source.tangents.is_empty(),
            set_count: self.converted.sets.len(),
            attributes: self.passed_on().map(kind).collect(),
            targets: targets.collect(),
        }
    }

    /// Whether both can stand in one primitive.
    pub fn fits(&self, other: &Self) -> bool {
        self.converted.number == other.converted.number
            && self.piece.coordinates == other.piece.coordinates
            && self.form() == other.form()
    }

    /// Attributes that go along as they are.
    fn passed_on(&self) -> impl Iterator<Item = &'a Attribute> {
        let takes_colors = self.converted.takes_colors;
        passed_on(self.source).filter(move |own| !(takes_colors && own.semantic == VERTEX_COLORS))
    }

    fn corners(&self) -> Corners {
        let kept = Kept {
            normals: !self.is_framed(),
            tangents: self.keeps_tangents(),
            colors: !self.converted.takes_colors,
            sets: &self.converted.sets,
        };
        let used = self.piece.triangles.iter().flat_map(|triangle| triangle.vertices);
        Corners::distinct(self.piece, &alike::firsts(self.source, &kept, used))
    }

    /// The name of a morph target's attribute in the file, or `None` where what it moves was replaced.
    fn target_name(&self, attribute: &Attribute) -> Option<String> {
        match attribute.semantic.strip_prefix("TEXCOORD_") {
            Some(set) => {
                let set: usize = set.parse().ok()?;
                let place = self.converted.sets.iter().position(|own| *own == set)?;
                Some(format!("TEXCOORD_{}", place + 1))
            }
            None if attribute.semantic == "TANGENT" && !self.keeps_tangents() => None,
            None => Some(attribute.semantic.clone()),
        }
    }
}

/// Members in a row, each with its corners and their vertices of the asset's primitive; all of one form.
pub struct Geometry<'a> {
    members: Vec<(Member<'a>, Corners, Vec<u32>)>,
}

impl<'a> Geometry<'a> {
    /// `members`: at least one; all [fit](Member::fits).
    pub fn new(members: &[Member<'a>]) -> Self {
        let own = |member: &Member<'a>| {
            let corners = member.corners();
            let vertices = corners.vertices();
            (member.clone(), corners, vertices)
        };
        Self { members: members.iter().map(own).collect() }
    }

    pub fn vertex_count(&self) -> usize {
        self.members.iter().map(|(_, corners, _)| corners.corners.len()).sum()
    }

    /// Whether triangles that are written in a row begin with one vertex exactly where they are of one polygon of the
    /// source, and all polygons are whole.
    pub fn keeps_polygons(&self) -> bool {
        self.members.iter().all(|(member, corners, _)| ngons::are_kept(member, &corners.indices))
    }

    pub fn add_indices(&self, draft: &mut Draft<'_>) -> usize {
        let mut indices = Vec::new();
        let mut first = 0;
        for (_, corners, _) in &self.members {
            indices.extend(corners.indices.iter().map(|index| first + index));
            first += corners.corners.len() as u32;
        }
        vertices::add_indices(draft, &indices, self.vertex_count())
    }

    /// Values of every vertex, by member.
    fn all<T>(&self, values: impl Fn(&Member<'a>, &Corners, &[u32]) -> Vec<T>) -> Vec<T> {
        self.members.iter().flat_map(|(member, corners, own)| values(member, corners, own)).collect()
    }

    /// An attribute of every vertex: the one that `of` finds in each member.
    fn add_attribute<'m>(
        &'m self,
        draft: &mut Draft<'_>,
        of: impl Fn(&Member<'a>) -> Option<&'m Attribute>,
    ) -> Option<usize>
    where
        'a: 'm,
    {
        let runs: Option<Vec<(&Attribute, &[u32])>> =
            self.members.iter().map(|(member, _, own)| Some((of(member)?, own.as_slice()))).collect();
        vertices::add_attribute(draft, &runs?)
    }

    pub fn add_attributes(&self, draft: &mut Draft<'_>) -> Map<String, Value> {
        let Some((first, ..)) = self.members.first() else { return Map::new() };
        let mut attributes = Map::new();
        let mut add = |name: &str, accessor: usize| attributes.insert(name.to_owned(), accessor.into());
        let positions: Vec<Vec3> = self.all(|member, _, own| pick(&member.source.positions, own));
        add("POSITION", vertices::add_positions(draft, &positions));
        if first.is_framed() {
            let frames = self.all(|_, corners, _| corners.corners.iter().filter_map(|c| c.frame).collect());
            let normals: Vec<_> = frames.iter().map(|frame| frame.normal.to_array()).collect();
            let tangents: Vec<_> = frames.iter().map(|frame| frame.tangent.to_array()).collect();
            add("NORMAL", vertices::add_floats(draft, &normals));
            add("TANGENT", vertices::add_floats(draft, &tangents));
        } else {
            if !first.source.normals.is_empty() {
                let normals: Vec<Vec3> = self.all(|member, _, own| pick(&member.source.normals, own));
                add("NORMAL", vertices::add_floats(draft, &arrays(&normals)));
            }
            if !first.source.tangents.is_empty() && first.keeps_tangents() {
                let tangents: Vec<Vec4> = self.all(|member, _, own| pick(&member.source.tangents, own));
                add("TANGENT", vertices::add_floats(draft, &arrays(&tangents)));
            }
        }
        let places = self.all(|member, corners, _| {
            coordinates::texcoords(&member.piece.coordinates, &corners.corners, member.converted.size)
        });
        add("TEXCOORD_0", vertices::add_floats(draft, &places));
        for place in 0..first.converted.sets.len() {
            let values: Vec<Vec2> = self.all(|member, _, own| set_of(member, place, own));
            add(&format!("TEXCOORD_{}", place + 1), vertices::add_floats(draft, &arrays(&values)));
        }
        for attribute in first.passed_on() {
            let same =
                |member: &Member<'a>| member.passed_on().find(|own| own.semantic == attribute.semantic);
            if let Some(accessor) = self.add_attribute(draft, same) {
                add(&attribute.semantic, accessor);
            }
        }
        let corners: Vec<Corner> = self.all(|_, corners, _| corners.corners.clone());
        coordinates::add(draft, &corners, &mut attributes);
        attributes
    }

    pub fn add_targets(&self, draft: &mut Draft<'_>) -> Vec<Value> {
        let Some((first, ..)) = self.members.first() else { return Vec::new() };
        let mut targets = Vec::with_capacity(first.source.targets.len());
        for (number, target) in first.source.targets.iter().enumerate() {
            let mut json = Map::new();
            for name in target.attributes.iter().filter_map(|attribute| first.target_name(attribute)) {
                let same = |member: &Member<'a>| {
                    let own = member.source.targets.get(number)?.attributes.iter();
                    own.into_iter().find(|own| member.target_name(own).as_ref() == Some(&name))
                };
                if let Some(accessor) = self.add_attribute(draft, same) {
                    json.insert(name, accessor.into());
                }
            }
            if json.is_empty() {
                // glTF has no empty target, and weights count on its place in the row.
                let zeros = vertices::add_zero_positions(draft, self.vertex_count());
                json.insert("POSITION".to_owned(), zeros.into());
            }
            targets.push(Value::Object(json));
        }
        targets
    }

    /// # Errors
    /// `Internal` where cuts are about another material's textures, or other triangles.
    pub fn add_cuts(&self, draft: &mut Draft<'_>, finished: &Finished) -> Result<Map<String, Value>> {
        let mut cuts = Map::new();
        let Some((first, ..)) = self.members.first() else { return Ok(cuts) };
        for (Member { piece, .. }, ..) in &self.members {
            let fits = |texture: usize, bits: &[u8]| {
                let texture = finished.textures.get(texture);
                texture.is_some_and(|texture| texture.is_of(piece.material, piece.part))
                    && bits.len() == piece.triangles.len()
            };
            let is_any = |bits: &[u8]| bits.iter().any(|bits| *bits != 0);
            if piece.cuts.iter().any(|cut| is_any(&cut.bits) && !fits(cut.texture, &cut.bits)) {
                return Err(Error::internal("cuts do not fit their primitive's material and triangles"));
            }
        }
        for (number, texture) in finished.textures_of(first.piece.material, first.piece.part) {
            let bits = self.all(|member, _, _| {
                let own = member.piece.cuts.iter().find(|cut| cut.texture == number);
                let bit = |bits: Option<&[u8]>, triangle: usize| {
                    bits.and_then(|bits| bits.get(triangle)).copied().unwrap_or(0)
                };
                let own = own.map(|cut| cut.bits.as_slice());
                let both = |triangle| bit(own, triangle) | bit(Some(member.border), triangle);
                (0..member.piece.triangles.len()).map(both).collect()
            });
            if bits.iter().all(|bits| *bits == 0) {
                continue;
            }
            let accessor = vertices::add_bytes(draft, &bits);
            for slot in &texture.slots {
                cuts.insert(slot.gltf_name().to_owned(), accessor.into());
            }
        }
        Ok(cuts)
    }
}

/// A set of the source that stays, behind the new one. One that the primitive lacks reads (0, 0), but the sets behind
/// it need it in the file.
fn set_of(member: &Member<'_>, place: usize, vertices: &[u32]) -> Vec<Vec2> {
    let set = member.converted.sets.get(place).and_then(|set| member.source.texcoords.get(*set));
    match set.filter(|values| !values.is_empty()) {
        Some(values) => pick(values, vertices),
        None => vec![Vec2::ZERO; vertices.len()],
    }
}

/// Attributes that are copied vertex by vertex; an earlier conversion's coordinates are not.
pub fn passed_on(source: &Primitive) -> impl Iterator<Item = &Attribute> {
    source.attributes.iter().filter(|attribute| !attribute.semantic.starts_with("_MCT_"))
}

fn pick<T: Copy>(values: &[T], vertices: &[u32]) -> Vec<T> {
    vertices.iter().map(|vertex| values[*vertex as usize]).collect()
}

pub fn arrays<T: Copy + Into<[f32; N]>, const N: usize>(values: &[T]) -> Vec<[f32; N]> {
    values.iter().map(|value| (*value).into()).collect()
}
