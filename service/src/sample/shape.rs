//! A tube around a trefoil knot, cut into islands: rectangles of the atlas, each turned in its cell.

use std::f32::consts::TAU;

use glam::{Mat2, Vec2, Vec3, Vec4};

/// Islands stand in a square of cells.
pub const CELLS_PER_SIDE: usize = 3;
pub const ISLAND_COUNT: usize = CELLS_PER_SIDE * CELLS_PER_SIDE;
/// Quads of one island, along the tube and around it.
pub const ALONG: usize = 16;
pub const AROUND: usize = 12;

/// Rings of the whole tube, which closes.
const RING_COUNT: usize = ISLAND_COUNT * ALONG;
const KNOT_RADIUS: f32 = 2.0;
const KNOT_DEPTH: f32 = 0.8;
const TUBE_RADIUS: f32 = 0.5;
/// Sides of an island over the atlas's side. With its diagonal of 0.307 it fits into a cell at any angle.
const ISLAND_SIZE: Vec2 = Vec2::new(0.221, 0.213);
/// No two alike, and none a quarter turn.
const TURNS_DEGREES: [f32; ISLAND_COUNT] = [17.0, 61.0, 143.0, 8.0, 197.0, 102.0, 259.0, 331.0, 74.0];

/// One vertex of an island.
#[derive(Clone, Copy)]
pub struct Vertex {
    pub position: Vec3,
    pub normal: Vec3,
    pub tangent: Vec4,
    /// glTF's convention: v down.
    pub uv: Vec2,
}

/// An island: a grid of `ALONG + 1` by `AROUND + 1` vertices; `vertices[j * (ALONG + 1) + i]`.
pub struct Island {
    pub vertices: Vec<Vertex>,
    center: Vec2,
    turn: Mat2,
}

pub struct Shape {
    pub islands: Vec<Island>,
}

impl Island {
    pub fn vertex(&self, i: usize, j: usize) -> &Vertex {
        &self.vertices[j * (ALONG + 1) + i]
    }

    /// A place of the atlas in the island's own grid: whole numbers at the vertices, from (0, 0) to
    /// (`ALONG`, `AROUND`).
    pub fn grid_place(&self, uv: Vec2) -> Vec2 {
        let local = self.turn.transpose() * (uv - self.center) / ISLAND_SIZE + 0.5;
        local * Vec2::new(ALONG as f32, AROUND as f32)
    }

    /// How far a place of the atlas lies outside of the island, in units of the atlas; 0 inside.
    pub fn distance(&self, uv: Vec2) -> f32 {
        let local = self.turn.transpose() * (uv - self.center);
        (local.abs() - ISLAND_SIZE * 0.5).max(Vec2::ZERO).length()
    }

    /// The three vertices of the triangle at a place of the grid (of the nearest one outside of it), with
    /// the place's weights; triangles as in [`triangles`].
    pub fn triangle_at(&self, grid: Vec2) -> [(&Vertex, f32); 3] {
        let cell = grid.floor().clamp(Vec2::ZERO, Vec2::new((ALONG - 1) as f32, (AROUND - 1) as f32));
        let (i, j) = (cell.x as usize, cell.y as usize);
        let in_cell = grid - cell;
        let (start, end) = (self.vertex(i, j), self.vertex(i + 1, j + 1));
        if in_cell.x >= in_cell.y {
            [(start, 1.0 - in_cell.x), (self.vertex(i + 1, j), in_cell.x - in_cell.y), (end, in_cell.y)]
        } else {
            [(start, 1.0 - in_cell.y), (end, in_cell.x), (self.vertex(i, j + 1), in_cell.y - in_cell.x)]
        }
    }
}

/// Corners of an island's triangles, counterclockwise from outside.
pub fn triangles() -> impl Iterator<Item = [usize; 3]> {
    let number = |i: usize, j: usize| j * (ALONG + 1) + i;
    (0..AROUND).flat_map(move |j| {
        (0..ALONG).flat_map(move |i| {
            let (a, b, c, d) = (number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1));
            [[a, c, b], [a, d, c]]
        })
    })
}

/// The whole model.
pub fn knot() -> Shape {
    let islands = (0..ISLAND_COUNT).map(|number| {
        let cell = Vec2::new((number % CELLS_PER_SIDE) as f32, (number / CELLS_PER_SIDE) as f32);
        let center = (cell + 0.5) / CELLS_PER_SIDE as f32;
        let turn = Mat2::from_angle(TURNS_DEGREES[number].to_radians());
        let mut island = Island { vertices: Vec::new(), center, turn };
        for j in 0..=AROUND {
            for i in 0..=ALONG {
                island.vertices.push(vertex(&island, number * ALONG + i, i, j));
            }
        }
        island
    });
    Shape { islands: islands.collect() }
}

fn vertex(island: &Island, ring: usize, i: usize, j: usize) -> Vertex {
    // Taken modulo the counts, so that both sides of a seam are the same to the bit.
    let angle = (ring % RING_COUNT) as f32 / RING_COUNT as f32 * TAU;
    let around = (j % AROUND) as f32 / AROUND as f32 * TAU;
    let along = (center_line(angle + 1e-3) - center_line(angle - 1e-3)).normalize();
    let outward = outward(angle);
    let across = (outward - along * outward.dot(along)).normalize();
    let side = along.cross(across);
    let normal = across * around.cos() + side * around.sin();
    let position = center_line(angle) + normal * TUBE_RADIUS;
    let circle = side * around.cos() - across * around.sin();
    // The atlas's u axis, seen in the island's grid, seen in space.
    let u_axis = island.turn.transpose() * Vec2::X;
    let tangent = along * u_axis.x + circle * u_axis.y;
    let local = Vec2::new(i as f32 / ALONG as f32, j as f32 / AROUND as f32) - 0.5;
    Vertex {
        position,
        normal,
        // The bitangent of glTF points against v, because v runs down.
        tangent: tangent.normalize().extend(1.0),
        uv: island.center + island.turn * (local * ISLAND_SIZE),
    }
}

fn center_line(angle: f32) -> Vec3 {
    let (sin3, cos3) = (3.0 * angle).sin_cos();
    let (sin2, cos2) = (2.0 * angle).sin_cos();
    let radius = KNOT_RADIUS + KNOT_DEPTH * cos3;
    Vec3::new(radius * cos2, radius * sin2, KNOT_DEPTH * sin3)
}

/// Away from the middle of the torus that the knot winds around.
fn outward(angle: f32) -> Vec3 {
    let (sin3, cos3) = (3.0 * angle).sin_cos();
    let (sin2, cos2) = (2.0 * angle).sin_cos();
    Vec3::new(cos3 * cos2, cos3 * sin2, sin3)
}
