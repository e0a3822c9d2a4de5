//! Meshes: primitives with their vertex attributes, morph targets and faces.

use super::super::Context;
use super::super::geometry;
use super::super::json::At;
use super::super::text::quoted;
use super::accessors::{Accessor, Store, type_name};
use super::faces::{Mode, unroll};
use super::mesh_colors;
use super::ngons;
use super::typed;
use crate::asset::{Attribute, Mesh, MorphTarget, Primitive};
use crate::error::Result;
use crate::watch;

/// Sets of texture coordinates that a primitive may have.
pub const TEXCOORD_SETS_MAX: usize = 16;

pub(super) fn read(root: &At, store: &Store, context: &mut Context) -> Result<Vec<Mesh>> {
    let material_count = root.list("materials")?.len();
    let mut meshes = Vec::new();
    for at in &root.objects("meshes")? {
        let mut primitives = Vec::new();
        let has_ngons = ngons::is_marked(at)?;
        for at in &at.objects("primitives")? {
            watch::check(context.watch)?;
            primitives.push(read_primitive(at, has_ngons, material_count, store, context)?);
        }
        meshes.push(Mesh { name: at.string("name")?.unwrap_or_default().to_owned(), primitives });
    }
    Ok(meshes)
}

/// `has_ngons`: the mesh says that triangles are in the order of polygons.
fn read_primitive(
    at: &At,
    has_ngons: bool,
    material_count: usize,
    store: &Store,
    context: &mut Context,
) -> Result<Primitive> {
    let attributes = at.object("attributes")?.ok_or_else(|| at.error("`attributes` is missing"))?;
    let Some(position) = accessor_at(&attributes, "POSITION", store)? else {
        return Err(attributes.error("`POSITION` is missing"));
    };
    let vertex_count = position.count;
    context.budget.take_vertices(vertex_count as u64, &at.pointer)?;
    let mut primitive = Primitive {
        material: at.index("material", material_count, "materials")?,
        positions: typed::positions(store, position, &mut context.budget)?,
        ..Primitive::default()
    };
    let mut sets = Vec::new();
    for (semantic, member) in attributes.members() {
        let accessor = checked_accessor(&member, store, vertex_count)?;
        let budget = &mut context.budget;
        match semantic {
            "POSITION" => {}
            "NORMAL" => primitive.normals = typed::normals(store, accessor, budget)?,
            "TANGENT" => primitive.tangents = typed::tangents(store, accessor, budget)?,
            _ => match semantic.strip_prefix("TEXCOORD_") {
                Some(set) => {
                    let set = set_number(set, &member)?;
                    sets.push((set, typed::texcoords(store, accessor, semantic, budget)?));
                }
                None => primitive.attributes.push(raw(semantic, accessor, store, context)?),
            },
        }
    }
    primitive.texcoords = in_order(sets, vertex_count, &attributes, context)?;
    for target in at.objects("targets")? {
        primitive.targets.push(read_target(&target, store, vertex_count, context)?);
    }
    read_faces(at, has_ngons, &mut primitive, store, context)?;
    geometry::finish(&mut primitive, &at.pointer, &mut context.warnings);
    Ok(primitive)
}

fn accessor_at<'s>(at: &At, key: &str, store: &'s Store) -> Result<Option<&'s Accessor>> {
    let index = at.index(key, store.accessors.len(), "accessors")?;
    Ok(index.map(|index| &store.accessors[index]))
}

/// The accessor that an attribute names, with as many elements as there are vertices.
fn checked_accessor<'s>(member: &At, store: &'s Store, vertex_count: usize) -> Result<&'s Accessor> {
    let accessor = &store.accessors[member.index_below(store.accessors.len(), "accessors")?];
    if accessor.count != vertex_count {
        return Err(member
            .error(format!("the attribute has {} elements, POSITION has {vertex_count}", accessor.count)));
    }
    Ok(accessor)
}

fn set_number(digits: &str, member: &At) -> Result<usize> {
    match digits.parse::<usize>() {
        Ok(set) if set < TEXCOORD_SETS_MAX && digits.len() == set.to_string().len() => Ok(set),
        _ => Err(member.error(format!(
            "texture coordinate sets are numbered 0 to {}, but this is {}",
            TEXCOORD_SETS_MAX - 1,
            quoted(digits)
        ))),
    }
}

/// Sets by number; those that are skipped are all zero.
fn in_order(
    mut sets: Vec<(usize, Vec<glam::Vec2>)>,
    vertex_count: usize,
    at: &At,
    context: &mut Context,
) -> Result<Vec<Vec<glam::Vec2>>> {
    sets.sort_by_key(|(set, _)| *set);
    let mut texcoords = Vec::new();
    for (set, coordinates) in sets {
        while texcoords.len() < set {
            let detail = "numbers left out between texture coordinate sets; those sets are zero everywhere";
            context.warnings.add("missing_texcoord_set", &at.pointer, detail);
            context.budget.take_bytes(8 * vertex_count as u64, &at.pointer)?;
            texcoords.push(vec![glam::Vec2::ZERO; vertex_count]);
        }
        texcoords.push(coordinates);
    }
    Ok(texcoords)
}

fn raw(semantic: &str, accessor: &Accessor, store: &Store, context: &mut Context) -> Result<Attribute> {
    Ok(Attribute {
        semantic: semantic.to_owned(),
        component_type: accessor.component.as_gl_enum(),
        kind: type_name(accessor.dimensions).to_owned(),
        normalized: accessor.normalized,
        element_bytes: accessor.element_bytes(),
        bytes: store.packed(accessor, &mut context.budget)?,
    })
}

fn read_target(at: &At, store: &Store, vertex_count: usize, context: &mut Context) -> Result<MorphTarget> {
    let mut attributes = Vec::new();
    for (semantic, member) in at.members() {
        let accessor = checked_accessor(&member, store, vertex_count)?;
        attributes.push(raw(semantic, accessor, store, context)?);
    }
    Ok(MorphTarget { attributes })
}

fn read_faces(
    at: &At,
    has_ngons: bool,
    primitive: &mut Primitive,
    store: &Store,
    context: &mut Context,
) -> Result<()> {
    let code = at.size("mode")?.unwrap_or(4);
    let Some(mode) = Mode::from_code(code) else {
        return Err(at.error(format!("mode {code} is not one of 0 to 6")));
    };
    let vertex_count = primitive.positions.len();
    let budget = &mut context.budget;
    primitive.faces = match accessor_at(at, "indices", store)? {
        Some(accessor) => {
            let indices = typed::indices(store, accessor, vertex_count, budget)?;
            unroll(mode, indices.len(), |corner| indices[corner], &at.pointer, budget)?
        }
        // The vertex limit keeps the count within 32 bits only by its default, so this is checked.
        None => {
            if u32::try_from(vertex_count).is_err() {
                return Err(at.error("more vertices than 32-bit indices can name"));
            }
            unroll(mode, vertex_count, |corner| corner as u32, &at.pointer, budget)?
        }
    };
    let is_listed = mesh_colors::join_quads(at, &mut primitive.faces, store, budget)?;
    // A list of quads says more, and mesh colors count on it.
    if !is_listed && mode == Mode::Triangles && (has_ngons || ngons::is_marked(at)?) {
        ngons::join_quads(primitive, &at.pointer, &mut context.warnings);
    }
    Ok(())
}
