use super::*;
use crate::math::random::Random;

fn edge(a: usize, b: usize, weight: i64) -> WeightedEdge {
    WeightedEdge { nodes: [a as u32, b as u32], weight }
}

/// The weight of the best matching, by trying every set of nodes.
fn best_of_all(node_count: usize, edges: &[WeightedEdge]) -> i64 {
    let mut best = vec![0; 1 << node_count];
    for set in 1..1usize << node_count {
        let low = set.trailing_zeros();
        best[set] = best[set & (set - 1)];
        for edge in edges {
            let pair = (1 << edge.nodes[0]) | (1 << edge.nodes[1]);
            if edge.nodes[0] != edge.nodes[1] && edge.nodes.contains(&low) && set & pair == pair {
                best[set] = best[set].max(best[set & !pair] + edge.weight);
            }
        }
    }
    best[best.len() - 1]
}

/// The weight of a matching, after seeing that it is one.
fn weight_of(partners: &[Option<u32>], edges: &[WeightedEdge]) -> i64 {
    let mut heaviest = std::collections::BTreeMap::new();
    for edge in edges {
        let [a, b] = edge.nodes;
        let best = heaviest.entry([a.min(b), a.max(b)]).or_insert(edge.weight);
        *best = edge.weight.max(*best);
    }
    let mut total = 0;
    for (node, partner) in partners.iter().enumerate() {
        let Some(partner) = *partner else { continue };
        assert_eq!(partners[partner as usize], Some(node as u32));
        if (node as u32) < partner {
            total += heaviest[&[node as u32, partner]];
        }
    }
    total
}

/// The blossoms around a node, the innermost first, with their duals.
fn blossoms(matcher: &Matcher, node: u32) -> Vec<(u32, i64)> {
    let up = |at: u32| Some(matcher.forest.cell(at).parent).filter(|&up| up != NONE);
    std::iter::successors(up(node), |&at| up(at)).map(|at| (at, matcher.forest.cell(at).dual)).collect()
}

/// The duals of all nodes.
fn node_duals(matcher: &Matcher) -> Vec<i64> {
    let nodes = matcher.forest.cells[..matcher.forest.graph.node_count()].iter();
    nodes.map(|node| node.dual + matcher.forest.cell(node.around).shift).collect()
}

/// Solves, and proves by the duals that no matching weighs more. Returns the weight and how many blossoms have a
/// dual.
fn certified(node_count: usize, edges: &[WeightedEdge]) -> (i64, usize) {
    let mut matcher = solved(node_count, edges);
    let duals = node_duals(&matcher);
    let around: Vec<Vec<(u32, i64)>> = (0..node_count as u32).map(|node| blossoms(&matcher, node)).collect();
    let partners = partners(&mut matcher.forest);
    let mut bound: i64 = duals.iter().sum();
    assert!(duals.iter().all(|&dual| dual >= 0));
    for WeightedEdge { nodes: [a, b], weight } in edges {
        let (around_a, around_b) = (around[*a as usize].iter().rev(), around[*b as usize].iter().rev());
        let both: i64 =
            around_a.zip(around_b).take_while(|(a, b)| a == b).map(|(blossom, _)| blossom.1).sum();
        let lack = 2 * weight - duals[*a as usize] - duals[*b as usize] - both;
        assert!(a == b || lack <= 0, "edge {a} {b} lacks {lack}");
    }
    let mut sizes = std::collections::BTreeMap::new();
    for &(blossom, dual) in around.iter().flatten() {
        assert!(dual >= 0);
        sizes.entry(blossom).or_insert((0, dual)).0 += 1;
    }
    for &(size, dual) in sizes.values() {
        assert_eq!(size % 2, 1);
        bound += (size / 2) * dual;
    }
    let total = weight_of(&partners, edges);
    assert_eq!(2 * total, bound);
    (total, sizes.values().filter(|blossom| blossom.1 > 0).count())
}

/// The dual graph of a sheet of `side` by `side` cells, each cut along one of its diagonals: one node for each
/// triangle.
fn sheet(
    side: usize,
    mut is_rising: impl FnMut() -> bool,
    mut weight: impl FnMut() -> i64,
) -> (usize, Vec<WeightedEdge>) {
    let rising: Vec<bool> = (0..side * side).map(|_| is_rising()).collect();
    let mut edges = Vec::new();
    for (cell, &is_rising) in rising.iter().enumerate() {
        // The first triangle has the lower side; left belongs to it where the diagonal falls.
        let (low, high) = (2 * cell, 2 * cell + 1);
        edges.push(edge(low, high, weight()));
        if cell % side + 1 < side {
            let right = if is_rising { low } else { high };
            let left = if rising[cell + 1] { high + 2 } else { low + 2 };
            edges.push(edge(right, left, weight()));
        }
        if cell + side < side * side {
            edges.push(edge(high, 2 * (cell + side), weight()));
        }
    }
    (2 * side * side, edges)
}

/// The dual graph of an icosahedron whose faces are cut in four `levels` times: twelve circles of five, the others
/// of six.
fn sphere(levels: usize, mut weight: impl FnMut() -> i64) -> (usize, Vec<WeightedEdge>) {
    let mut faces: Vec<[usize; 3]> = Vec::new();
    for i in 0..5 {
        let (a, b) = (1 + i, 1 + (i + 1) % 5);
        faces.extend([[0, a, b], [a, a + 5, b], [b, a + 5, b + 5], [11, b + 5, a + 5]]);
    }
    let mut vertices = 12;
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: usize, b: usize| {
            *middles.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                vertices += 1;
                vertices - 1
            })
        };
        let cut = |&[a, b, c]: &[usize; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        faces = faces.iter().flat_map(cut).collect();
    }
    let mut sides = std::collections::BTreeMap::new();
    let mut edges = Vec::new();
    for (face, &[a, b, c]) in faces.iter().enumerate() {
        for [a, b] in [[a, b], [b, c], [c, a]] {
            if let Some(other) = sides.insert([a.min(b), a.max(b)], face) {
                edges.push(edge(other, face, weight()));
            }
        }
    }
    (faces.len(), edges)
}

#[test]
fn nothing_and_one_node() {
    assert_eq!(maximum_weight_matching(0, &[]), []);
    assert_eq!(maximum_weight_matching(1, &[]), [None]);
    assert_eq!(maximum_weight_matching(1, &[edge(0, 0, 5)]), [None]);
    assert_eq!(maximum_weight_matching(2, &[edge(0, 1, 0)]), [None, None]);
    assert_eq!(maximum_weight_matching(3, &[edge(0, 1, 2), edge(2, 1, 3)]), [None, Some(2), Some(1)]);
}

#[test]
fn small_graphs_as_by_trying_all() {
    let mut random = Random(1);
    for _ in 0..40_000 {
        let nodes = 2 + random.below(8) as usize;
        let heaviest = [1, 2, 3, 6, 20, 1000][random.below(6) as usize];
        let edges: Vec<WeightedEdge> = (0..random.below(2 * nodes as u32 + 4))
            .map(|_| {
                let [a, b] = [(); 2].map(|_| random.below(nodes as u32) as usize);
                edge(a, b, 1 + i64::from(random.below(heaviest)))
            })
            .collect();
        let (weight, _) = certified(nodes, &edges);
        assert_eq!(weight, best_of_all(nodes, &edges), "{nodes} {edges:?}");
    }
}

#[test]
fn sheets_have_a_proof() {
    let mut random = Random(2);
    for is_mixed in [false, true] {
        for classes in [&[1][..], &[3, 9, 33, 129], &[3, 9, 9], &[]] {
            let mut diagonals = Random(3);
            let is_rising = || is_mixed && diagonals.below(2) == 0;
            let count = classes.len() as u32;
            let weight = || {
                if count == 0 {
                    1 + i64::from(random.below(1000))
                } else {
                    classes[random.below(count) as usize]
                }
            };
            let (nodes, edges) = sheet(50, is_rising, weight);
            let (total, blossoms) = certified(nodes, &edges);
            assert!(count != 1 || total == nodes as i64 / 2);
            // Cut along the same diagonal, all circles around a vertex have six triangles, and no blossom is needed.
            assert_eq!(blossoms > 0, is_mixed && count != 1, "{is_mixed} {classes:?} {blossoms}");
            // Where edges are missing some nodes stay alone, and others are near to it.
            let holes: Vec<WeightedEdge> = edges.into_iter().filter(|_| random.below(8) > 0).collect();
            certified(nodes, &holes);
        }
    }
}

#[test]
fn spheres_have_a_proof() {
    let mut random = Random(4);
    let (nodes, edges) = sphere(4, || 7);
    assert_eq!(certified(nodes, &edges).0, 7 * nodes as i64 / 2);
    let (nodes, edges) = sphere(4, || 1 + i64::from(random.below(50)));
    certified(nodes, &edges);
}

#[test]
fn dense_graphs_have_a_proof() {
    let mut random = Random(5);
    for nodes in [9, 15, 30, 61] {
        for heaviest in [1, 4, 1000] {
            let pairs = (0..nodes).flat_map(|a| (0..a).map(move |b| (a, b)));
            let edges: Vec<WeightedEdge> =
                pairs.map(|(a, b)| edge(a, b, 1000 + i64::from(random.below(heaviest)))).collect();
            let (total, _) = certified(nodes, &edges);
            assert!(total >= 1000 * (nodes / 2) as i64);
        }
    }
}

/// Triangles on a string, each hung at the one before: blossoms in blossoms, and a lone end that walks along all.
#[test]
fn nested_circles_have_a_proof() {
    let mut random = Random(6);
    for heaviest in [1, 3, 100] {
        let edges: Vec<WeightedEdge> = (0..3000)
            .flat_map(|i| [(2 * i, 2 * i + 1), (2 * i, 2 * i + 2), (2 * i + 1, 2 * i + 2)])
            .map(|(a, b)| edge(a, b, 100 + i64::from(random.below(heaviest))))
            .collect();
        certified(6001, &edges);
    }
}

#[test]
fn a_long_path() {
    let count = 200_000;
    let path = |nodes: usize, weight: fn(usize) -> i64| -> Vec<WeightedEdge> {
        (1..nodes).map(|i| edge(i - 1, i, weight(i))).collect()
    };
    assert_eq!(certified(count, &path(count, |_| 5)).0, 5 * count as i64 / 2);
    assert_eq!(certified(count + 1, &path(count + 1, |_| 5)).0, 5 * count as i64 / 2);
    // The heaviest edge at the end, and every second one before it.
    let rising: i64 = (1..count as i64).rev().step_by(2).sum();
    assert_eq!(certified(count, &path(count, |i| i as i64)).0, rising);
    // Heavy edges inside, and one light one more: together the light ones weigh more, from end to end.
    let turns = path(count, |i| 200_001 - i as i64 % 2);
    assert_eq!(certified(count, &turns).0, 200_000 * count as i64 / 2);
}

#[test]
fn a_star_and_heavy_edges() {
    let star: Vec<WeightedEdge> =
        (1..100_001).map(|leaf| edge(0, leaf, 1 + (leaf as i64 * 7919) % 100_003)).collect();
    let best = star.iter().map(|edge| edge.weight).max().unwrap();
    assert_eq!(certified(100_001, &star).0, best);
    let heavy = (1 << 60) - 1;
    let circle: Vec<WeightedEdge> = (0..5).map(|i| edge(i, (i + 1) % 5, heavy - (i as i64 % 2))).collect();
    let partners = maximum_weight_matching(5, &circle);
    assert_eq!(weight_of(&partners, &circle), 2 * heavy);
}

#[test]
fn the_same_every_time() {
    let mut random = Random(8);
    let (nodes, edges) = sheet(40, || random.below(2) == 0, || 4);
    let first = maximum_weight_matching(nodes, &edges);
    assert_eq!(first, std::thread::spawn(move || maximum_weight_matching(nodes, &edges)).join().unwrap());
}
