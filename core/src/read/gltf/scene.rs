//! The node graph: a forest, walked without recursion, to the places of meshes in the default scene.

use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::super::Limits;
use super::super::json::At;
use crate::asset::Instance;
use crate::error::{Error, ErrorCode, Result};

struct Node {
    children: Vec<usize>,
    parent: Option<usize>,
    mesh: Option<usize>,
    local: DAffine3,
}

pub(super) fn read(root: &At, limits: &Limits) -> Result<Vec<Instance>> {
    let count = root.list("nodes")?.len() as u64;
    if count > limits.nodes {
        let detail = format!("the model has {count} nodes; the limit is {} (limit `nodes`)", limits.nodes);
        let error = Error::new(ErrorCode::ModelTooLarge, detail).at("/nodes");
        return Err(error.limit(limits.nodes, count));
    }
    let nodes = read_nodes(root)?;
    check_acyclic(&nodes)?;
    let roots = scene_roots(root, &nodes)?;
    walk(&nodes, &roots)
}

fn read_nodes(root: &At) -> Result<Vec<Node>> {
    let mesh_count = root.list("meshes")?.len();
    let places = root.objects("nodes")?;
    let mut nodes = Vec::with_capacity(places.len());
    for at in &places {
        nodes.push(Node {
            children: indices(at, "children", places.len())?,
            parent: None,
            mesh: at.index("mesh", mesh_count, "meshes")?,
            local: local_transform(at)?,
        });
    }
    for index in 0..nodes.len() {
        for position in 0..nodes[index].children.len() {
            let child = nodes[index].children[position];
            if let Some(first) = nodes[child].parent.replace(index) {
                let detail =
                    format!("node {child} is a child of node {first} already; a node has one parent");
                return Err(Error::invalid(detail).at(format!("/nodes/{index}/children/{position}")));
            }
        }
    }
    Ok(nodes)
}

fn indices(at: &At, key: &str, length: usize) -> Result<Vec<usize>> {
    let pointer = format!("{}/{key}", at.pointer);
    let list = at.list(key)?.iter();
    list.enumerate()
        .map(|(position, value)| {
            At { value, pointer: format!("{pointer}/{position}") }.index_below(length, "nodes")
        })
        .collect()
}

/// With one parent each, whatever cannot be reached from a root hangs on a cycle.
fn check_acyclic(nodes: &[Node]) -> Result<()> {
    let mut reached = vec![false; nodes.len()];
    let mut open: Vec<usize> = (0..nodes.len()).filter(|&node| nodes[node].parent.is_none()).collect();
    while let Some(node) = open.pop() {
        reached[node] = true;
        open.extend(&nodes[node].children);
    }
    match reached.iter().position(|reached| !reached) {
        Some(node) => Err(Error::invalid("the node is its own ancestor").at(format!("/nodes/{node}"))),
        None => Ok(()),
    }
}

/// The nodes of the default scene, of the first one, or all without a parent.
fn scene_roots(root: &At, nodes: &[Node]) -> Result<Vec<usize>> {
    let scenes = root.objects("scenes")?;
    let default = root.index("scene", scenes.len(), "scenes")?.unwrap_or(0);
    let Some(scene) = scenes.get(default) else {
        return Ok((0..nodes.len()).filter(|&node| nodes[node].parent.is_none()).collect());
    };
    let roots = indices(scene, "nodes", nodes.len())?;
    let mut listed = vec![false; nodes.len()];
    for (position, &node) in roots.iter().enumerate() {
        let pointer = format!("{}/nodes/{position}", scene.pointer);
        if let Some(parent) = nodes[node].parent {
            let detail =
                format!("node {node} is a child of node {parent}; a scene lists nodes without a parent");
            return Err(Error::invalid(detail).at(pointer));
        }
        if std::mem::replace(&mut listed[node], true) {
            return Err(Error::invalid(format!("node {node} is listed twice")).at(pointer));
        }
    }
    Ok(roots)
}

fn walk(nodes: &[Node], roots: &[usize]) -> Result<Vec<Instance>> {
    let mut found = Vec::new();
    let mut open: Vec<(usize, DAffine3)> = roots.iter().map(|&node| (node, DAffine3::IDENTITY)).collect();
    while let Some((node, parent_world)) = open.pop() {
        let world = parent_world * nodes[node].local;
        if let Some(mesh) = nodes[node].mesh {
            let transform = world.as_affine3a();
            if !transform.is_finite() {
                let detail = "the node's transform to the world leaves single precision";
                return Err(Error::invalid(detail).at(format!("/nodes/{node}")));
            }
            found.push((node, Instance { mesh, transform }));
        }
        open.extend(nodes[node].children.iter().map(|&child| (child, world)));
    }
    found.sort_by_key(|(node, _)| *node);
    Ok(found.into_iter().map(|(_, instance)| instance).collect())
}

fn local_transform(at: &At) -> Result<DAffine3> {
    if let Some(matrix) = at.numbers::<16>("matrix")? {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        // Of a transform, this row is 0 0 0 1; exporters leave rounding in it.
        let bottom = matrix.row(3) - glam::DVec4::W;
        if bottom.abs().max_element() > 1e-4 {
            return Err(at.error("the last row of `matrix` is not 0 0 0 1"));
        }
        return Ok(DAffine3::from_mat4(matrix));
    }
    let vector = |key: &str| Ok(at.numbers::<3>(key)?.map(|numbers| DVec3::from(numbers.map(f64::from))));
    let rotation = match at.numbers::<4>("rotation")? {
        Some(numbers) => {
            let rotation = DQuat::from_array(numbers.map(f64::from));
            if rotation.length_squared() < 1e-12 {
                return Err(at.error("`rotation` is a quaternion without length"));
            }
            rotation.normalize()
        }
        None => DQuat::IDENTITY,
    };
    let scale = vector("scale")?.unwrap_or(DVec3::ONE);
    let translation = vector("translation")?.unwrap_or(DVec3::ZERO);
    Ok(DAffine3::from_scale_rotation_translation(scale, rotation, translation))
}
