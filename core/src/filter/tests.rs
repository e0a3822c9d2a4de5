mod footprints;

use glam::{Vec2, Vec3, Vec4};

use super::{Level, MeshColors, Triangles};
use crate::colors::{ChannelTopology, Cuts, FaceGrid, LevelNumbering, Resolutions};
use crate::mesh::{CanvasMesh, Polygons, build};

const LEVELS: usize = 6;

/// Two triangles and two quads, all of which share edges; the quads are parallelograms.
fn sheet() -> CanvasMesh {
    let positions =
        [[0.0, 0.0], [1.0, 0.1], [0.2, 1.0], [1.2, 1.1], [0.0, 2.0], [1.0, 2.1], [2.2, 1.6], [2.0, 0.6]];
    let positions = positions.map(|[x, y]| Vec3::new(x, y, 0.3 * x - y));
    let faces = [([0, 1, 2, 0], 3), ([3, 2, 1, 0], 3), ([2, 3, 5, 4], 4), ([1, 7, 6, 3], 4)];
    build([Polygons { mesh: 0, primitive: 0, positions: &positions, faces: &mut faces.into_iter() }])
}

/// Equal and unequal along edges, elongated, at vertex colors.
fn all_resolutions() -> Vec<Resolutions> {
    let lists = [
        [[3, 3], [3, 3], [3, 3], [3, 3]],
        [[2, 2], [4, 4], [1, 3], [4, 2]],
        [[0, 0], [3, 3], [4, 0], [0, 1]],
    ];
    lists.map(|faces| Resolutions { faces: faces.to_vec() }).to_vec()
}

/// What a sample holds, by the position of the samples.
type Colors<'a> = &'a dyn Fn(Vec3, usize) -> Vec4;

struct Case {
    canvas: CanvasMesh,
    topology: ChannelTopology,
    resolutions: Resolutions,
}

impl Case {
    fn new(canvas: CanvasMesh, resolutions: Resolutions) -> Self {
        let topology = ChannelTopology::new(&canvas, &resolutions, &Cuts::none(&canvas));
        Self { canvas, topology, resolutions }
    }

    fn all() -> Vec<Self> {
        all_resolutions().into_iter().map(|resolutions| Self::new(sheet(), resolutions)).collect()
    }

    fn position(&self, face: usize, at: Vec2) -> Vec3 {
        let face = &self.canvas.faces[face];
        let corner = |k: usize| self.canvas.positions[face.vertices[k] as usize];
        let start = corner(0);
        start + (corner(1) - start) * at.x + (corner(face.count() - 1) - start) * at.y
    }

    /// With the colors of every level, given a sample's position and its number.
    fn with<T>(
        &self,
        colors: Colors<'_>,
        triangles: Triangles<'_>,
        then: impl FnOnce(MeshColors<'_>) -> T,
    ) -> T {
        let numberings: Vec<_> = (0..LEVELS)
            .map(|level| LevelNumbering::new(&self.canvas, &self.topology, &self.resolutions, level))
            .collect();
        let values: Vec<Vec<Vec4>> =
            numberings.iter().map(|numbering| self.values(numbering, colors)).collect();
        let levels: Vec<_> =
            numberings.iter().zip(&values).map(|(numbering, values)| Level { numbering, values }).collect();
        then(MeshColors::new(&levels, triangles).unwrap())
    }

    fn values(&self, numbering: &LevelNumbering<'_>, colors: Colors<'_>) -> Vec<Vec4> {
        let mut values = vec![Vec4::NAN; numbering.sample_count()];
        for face in 0..self.canvas.faces.len() {
            for ((i, j), at) in grid(numbering, face) {
                let tap = numbering.tap(face, i, j);
                let sample = tap.samples[0] as usize;
                if tap.second == 0.0 {
                    values[sample] = colors(self.position(face, at), sample);
                }
            }
        }
        values
    }

    /// Places all over a face, its border included.
    fn places(&self, face: usize) -> Vec<Vec2> {
        let is_triangle = self.canvas.faces[face].is_triangle();
        let all = (0..=23).flat_map(|y| (0..=23).map(move |x| Vec2::new(x as f32, y as f32) / 23.0));
        all.filter(|at| !is_triangle || at.x + at.y <= 1.0).collect()
    }

    /// The place on each of the two faces of an edge, for every inner edge, at so many points along it.
    fn on_edges(&self, count: usize) -> Vec<[(usize, Vec2); 2]> {
        let inner =
            self.canvas.edges.iter().map(|edge| self.canvas.sides(edge)).filter(|sides| sides.len() == 2);
        let corner = |face: usize, k: usize| match (k, self.canvas.faces[face].is_triangle()) {
            (0, _) => Vec2::ZERO,
            (1, _) => Vec2::X,
            (2, false) => Vec2::ONE,
            _ => Vec2::Y,
        };
        let along = |step: usize| (step as f32 + 0.37) / count as f32;
        inner
            .flat_map(|sides| (0..count).map(move |step| (sides, along(step))))
            .map(|(sides, t)| {
                [0, 1].map(|k| {
                    let face = sides[k].face as usize;
                    let [low, high] =
                        [0, 1].map(|end| corner(face, self.canvas.corner_at_end(sides[k], end)));
                    (face, low.lerp(high, t))
                })
            })
            .collect()
    }
}

/// The points of a face's grid with their places.
fn grid(numbering: &LevelNumbering<'_>, face: usize) -> Vec<((u32, u32), Vec2)> {
    let shape = numbering.shape(face);
    let points = (0..=shape.segments[1]).flat_map(|j| (0..shape.point_count(j)).map(move |i| (i, j)));
    points.map(|(i, j)| ((i, j), Vec2::from(shape.unit(i, j)))).collect()
}

fn noise(_: Vec3, sample: usize) -> Vec4 {
    let of = |k: usize| ((sample * 7919 + k * 104_729) % 1009) as f32 / 1009.0;
    Vec4::new(of(1), of(2), of(3), of(4))
}

fn plane(position: Vec3, _: usize) -> Vec4 {
    let value = position.dot(Vec3::new(0.3, -0.7, 0.2)) + 0.4;
    Vec4::new(value, -value, 2.0 * value, 1.0)
}

const RIGHT: [&[u8]; 3] = [&[0, 1, 0, 0], &[1, 2, 0, 0], &[2, 0, 0, 0]];

fn all_triangles() -> [Triangles<'static>; 4] {
    [
        Triangles::Linear,
        Triangles::HalfSquares(RIGHT[0]),
        Triangles::HalfSquares(RIGHT[1]),
        Triangles::HalfSquares(RIGHT[2]),
    ]
}

#[test]
fn linear_functions_are_themselves() {
    for (case, triangles) in Case::all().iter().flat_map(|case| all_triangles().map(|t| (case, t))) {
        case.with(&plane, triangles, |colors| {
            for face in 0..4 {
                for at in case.places(face) {
                    let wanted = plane(case.position(face, at), 0);
                    for level in 0..LEVELS {
                        let found = colors.linear(face, at, level);
                        assert!((found - wanted).abs().max_element() < 1e-6, "{face} {at} {level}: {found}");
                    }
                    let between = colors.trilinear(face, at, 1.3);
                    assert!((between - wanted).abs().max_element() < 1e-6);
                }
            }
        });
    }
}

/// The same value from both sides of an edge, where exponents differ too; and where the right angles stand does not matter.
#[test]
fn edges_are_continuous() {
    for (case, triangles) in Case::all().iter().flat_map(|case| all_triangles().map(|t| (case, t))) {
        case.with(&noise, triangles, |colors| {
            for [(one, at), (other, there)] in case.on_edges(97) {
                for level in 0..LEVELS {
                    let pair = [colors.linear(one, at, level), colors.linear(other, there, level)];
                    assert!(
                        (pair[0] - pair[1]).abs().max_element() < 2e-5,
                        "{one} {other} {level}: {pair:?}"
                    );
                    let nearest = [colors.nearest(one, at, level), colors.nearest(other, there, level)];
                    assert_eq!(nearest[0], nearest[1], "{one} {at}, {other} {there}, level {level}");
                }
                let pair = [colors.trilinear(one, at, 2.7), colors.trilinear(other, there, 2.7)];
                assert!((pair[0] - pair[1]).abs().max_element() < 2e-5);
            }
        });
    }
}

#[test]
fn samples_are_found_where_they_are() {
    for case in Case::all() {
        case.with(&noise, Triangles::Linear, |colors| {
            for level in 0..LEVELS {
                let numbering = colors.levels[level].numbering;
                for (face, ((i, j), at)) in
                    (0..4).flat_map(|face| grid(numbering, face).into_iter().map(move |p| (face, p)))
                {
                    let tap = numbering.tap(face, i, j);
                    let wanted = tap.value(colors.levels[level].values);
                    assert_eq!(colors.linear(face, at, level), wanted);
                    if tap.second == 0.0 {
                        assert_eq!(
                            colors.nearest(face, at, level),
                            wanted,
                            "face {face}, level {level}, {i} {j}"
                        );
                    }
                }
            }
        });
    }
}

/// MC Figure 8a: hexagons. The largest weight is the sample that is nearest in a triangle of equal sides.
#[test]
fn nearest_samples_are_the_nearest() {
    let case = Case::new(sheet(), Resolutions::uniform([3, 3, 3, 3]));
    case.with(&noise, Triangles::Linear, |colors| {
        let numbering = colors.levels[1].numbering;
        for (face, at) in (0..4).flat_map(|face| case.places(face).into_iter().map(move |at| (face, at))) {
            let n = numbering.shape(face).segments[0] as f32;
            let skew = if face < 2 { 1.0 } else { 0.0 };
            let distance = |to: Vec2| {
                let Vec2 { x, y } = (at - to) * n;
                x * x + y * y + skew * x * y
            };
            let mut points = grid(numbering, face);
            points.sort_by(|a, b| distance(a.1).total_cmp(&distance(b.1)));
            if distance(points[1].1) - distance(points[0].1) > 1e-4 {
                let (i, j) = points[0].0;
                let wanted = numbering.tap(face, i, j).value(colors.levels[1].values);
                assert_eq!(colors.nearest(face, at, 1), wanted, "{face} {at}");
            }
        }
    });
}

/// Half squares show so much of a whole cell's twist more than three samples do: nothing on its sides, a quarter in its
/// middle. What they show of a cut cell is the same.
#[test]
fn half_squares_differ_by_the_twist_of_whole_cells() {
    let case = Case::new(sheet(), Resolutions::uniform([3, 3, 3, 3]));
    let values = case.with(&noise, Triangles::Linear, |colors| colors.levels[0].values.to_vec());
    let topology = &case.topology;
    let numbering = LevelNumbering::new(&case.canvas, topology, &case.resolutions, 0);
    let levels = [Level { numbering: &numbering, values: &values }];
    let linear = MeshColors::new(&levels, Triangles::Linear).unwrap();
    let half = MeshColors::new(&levels, Triangles::HalfSquares(RIGHT[0])).unwrap();
    let (mut whole_count, mut cut_count) = (0, 0);
    for at in case.places(0) {
        let (x, y) = (at.x * 8.0, at.y * 8.0);
        let (i, j) = (x as u32, y as u32);
        let more = half.linear(0, at, 0) - linear.linear(0, at, 0);
        if i + j >= 7 {
            cut_count += 1;
            assert!(more.abs().max_element() < 1e-6, "{at}");
            continue;
        }
        whole_count += 1;
        let value = |di: u32, dj: u32| numbering.tap(0, i + di, j + dj).value(&values);
        let twist = value(0, 0) + value(1, 1) - value(1, 0) - value(0, 1);
        let (x, y) = (x.fract(), y.fract());
        let share = if x + y <= 1.0 { x * y } else { (1.0 - x) * (1.0 - y) };
        assert!((more - twist * share).abs().max_element() < 1e-5, "{at}: {more}");
    }
    assert!(whole_count > 100 && cut_count > 30);
}

/// The faster reader of one face's alpha mixes as the reference does.
#[test]
fn alpha_of_a_grid_is_linear() {
    for case in Case::all() {
        case.with(&noise, Triangles::Linear, |colors| {
            let mut face_grid = FaceGrid::default();
            for (level, face) in (0..LEVELS).flat_map(|level| (0..4).map(move |face| (level, face))) {
                let Level { numbering, values } = colors.levels[level];
                numbering.fill(face, values, &mut face_grid);
                let [n, m] = face_grid.shape.segments.map(|segments| segments as f32);
                for at in case.places(face) {
                    let alpha = face_grid.alpha(at.x * n, at.y * m);
                    assert!((alpha - colors.linear(face, at, level).w).abs() < 2e-5, "{level} {face} {at}");
                }
            }
        });
    }
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let case = Case::new(sheet(), Resolutions::uniform([1, 1, 1, 1]));
    let numberings: Vec<_> = (0..2)
        .map(|level| LevelNumbering::new(&case.canvas, &case.topology, &case.resolutions, level))
        .collect();
    let values: Vec<Vec<Vec4>> = numberings.iter().map(|of| vec![Vec4::ONE; of.sample_count()]).collect();
    let level = |numbering: usize, values: &'_ [Vec4]| -> bool {
        let levels = [Level { numbering: &numberings[numbering], values }];
        MeshColors::new(&levels, Triangles::Linear).is_some()
    };
    assert!(level(0, &values[0]));
    assert!(!level(1, &values[1]), "not level 0");
    assert!(!level(0, &values[1]), "too few values");
    assert!(MeshColors::new(&[], Triangles::Linear).is_none());
    let levels = [Level { numbering: &numberings[0], values: &values[0] }];
    let half = |corners: &[u8]| MeshColors::new(&levels, Triangles::HalfSquares(corners)).is_some();
    assert!(half(&[0, 1, 2, 0]) && !half(&[0, 1, 2]) && !half(&[0, 3, 0, 0]));
}
