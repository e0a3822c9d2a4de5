//! The plan that leaves least of a level empty: many are tried, and the best are changed here and there for as long as the
//! work for a level lasts. Whatever is drawn is drawn from one seed.

use super::skyline::{Group, Piece, Plan, Put, Skyline, Taste};
use super::{ClassGrid, Level, Packing};
use crate::math::random::Random;

/// Widths that are tried at first, as shares of a square's side: the first, the last, and how many.
const WIDTHS: ([f64; 2], u32) = ([0.5, 1.6], 48);
/// Coprime to their number: the order they are tried in goes over the whole range, should the work end early.
const WIDTH_STRIDE: u32 = 29;
/// Grids that are looked at for a level: at most, and for each pair of groups.
const WORK_MAX: u64 = 2_000_000;
const WORK_MAX_QUICK: u64 = 200_000;
const WORK_OF_PAIR: u64 = 8_000;
/// The search ends where no more than one texel in so many is empty, and no more than one in so many is not read (empty, or
/// spare in a block); after that work where the second holds; after that work so many times in any case. Where spare ones alone
/// come near to the second, the empty ones need not be fewer than one in so many.
const EMPTY_PART: u64 = 100;
const UNREAD_PART: u64 = 50;
const EMPTY_PART_LEAST: u64 = 1000;
const LATE_COUNT: u64 = 24;
/// Plans that are changed by turns.
const PLANS_KEPT: usize = 20;
/// A changed plan may be worse by up to this share of the texels, less and less until the work is done, then anew.
const HEAT: f64 = 0.01;
/// Changes at a time.
const CHANGES_MAX: u32 = 4;
/// Height that grids should keep to beyond what all texels need, as a share of it.
const SPARE_MAX: f32 = 0.02;
/// What weighs how much; found by trying on six class lists of three models.
const TASTE: Taste = Taste { lost: 1.0, over: 6.0, full_width: 0.1, as_high: [0.06, 0.06], large: 2.0 };
/// Weights that are tried, as shares of these.
const WEIGHTS: [f32; 5] = [0.25, 0.5, 1.0, 2.0, 4.0];

/// When a search ends, and what it keeps to.
#[derive(Clone, Copy, Debug)]
pub struct Goal {
    /// Of the blocks' texels those that nobody reads.
    pub spare: u64,
    /// The texels of another way to set the level out, if there is one; where that is good enough the search ends as early as if
    /// it had found it.
    pub known: Option<u64>,
    pub side_limit: u32,
    pub packing: Packing,
}

/// The grids of a level with the least texels that were found within the limit.
pub fn search(pieces: &[Piece], goal: Goal) -> Option<Level> {
    let texels: u64 = pieces.iter().map(Piece::texels).sum();
    let widest = pieces.iter().map(|piece| piece.footprint[0]).max()?;
    let side = (texels as f64).sqrt();
    let [low, high] =
        WIDTHS.0.map(|share| ((side * share) as u32).clamp(widest, goal.side_limit.max(widest)));
    let joined = groups(pieces);
    let pair_count = (joined.len() * joined.len()) as u64;
    let mut search = Search {
        pieces,
        texels,
        goal,
        widths: [low, high],
        random: Random(5),
        skyline: Skyline::default(),
        work_max: match goal.packing {
            Packing::Quick => WORK_MAX_QUICK,
            Packing::Tight => WORK_MAX,
        }
        .min(pair_count * WORK_OF_PAIR),
        best: None,
    };
    let kept = search.first_plans(joined);
    search.change(kept);
    let best = search.best?;
    let mut grids = vec![ClassGrid::default(); pieces.len()];
    for put in &best.puts {
        let mut first = 0;
        for &class in &best.plan.groups[put.group].classes {
            grids[class] = ClassGrid { columns: put.columns, first, origin: put.origin };
            first += pieces[class].block_count;
        }
    }
    Some(Level { size: best.size, grids })
}

/// Classes of one footprint together.
fn groups(pieces: &[Piece]) -> Vec<Group> {
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by_key(|&class| pieces[class].footprint);
    let same = |&a: &usize, &b: &usize| pieces[a].footprint == pieces[b].footprint;
    order.chunk_by(same).map(|classes| Group::new(pieces, classes.to_vec())).collect()
}

impl Group {
    fn new(pieces: &[Piece], classes: Vec<usize>) -> Self {
        let block_count = classes.iter().map(|&class| pieces[class].block_count).sum();
        let footprint = pieces[classes[0]].footprint;
        Self { piece: Piece { footprint, block_count }, classes, favor: 0.0, columns_max: u32::MAX }
    }
}

struct Best {
    plan: Plan,
    puts: Vec<Put>,
    size: [u32; 2],
}

struct Search<'a> {
    /// By class.
    pieces: &'a [Piece],
    /// Of all blocks.
    texels: u64,
    goal: Goal,
    /// The least and the most.
    widths: [u32; 2],
    random: Random,
    skyline: Skyline,
    work_max: u64,
    best: Option<Best>,
}

impl Search<'_> {
    /// The texels of a plan, if there are no more than `texels_max` and it keeps to the limit.
    fn attempt(&mut self, plan: &mut Plan, texels_max: u64) -> Option<u64> {
        let width = u64::from(plan.width);
        plan.goal = (self.texels.div_ceil(width) as f32 * (1.0 + plan.spare)) as u32;
        let height_max = (texels_max / width).min(self.goal.side_limit.into()) as u32;
        let height = self.skyline.fill(plan, height_max)?;
        let texels = width * u64::from(height);
        let size = [plan.width, height];
        let is_best = self.best.as_ref().is_none_or(|best| texels < product(best.size));
        if is_best {
            self.best = Some(Best { plan: plan.clone(), puts: self.skyline.puts.clone(), size });
        }
        Some(texels)
    }

    /// The best of all widths, with classes of one footprint together and each alone.
    fn first_plans(&mut self, joined: Vec<Group>) -> Vec<(u64, Plan)> {
        let alone: Vec<Group> =
            (0..self.pieces.len()).map(|class| Group::new(self.pieces, vec![class])).collect();
        let mut starts = vec![joined];
        if starts[0].len() < alone.len() {
            starts.push(alone);
        }
        let [low, high] = self.widths;
        let count = WIDTHS.1.min(high - low + 1);
        let mut plans: Vec<(u64, Plan)> = Vec::new();
        for number in 0..WIDTHS.1 {
            let place = number * WIDTH_STRIDE % WIDTHS.1;
            if place >= count || self.skyline.work > self.work_max / 2 && !plans.is_empty() {
                continue;
            }
            let width = low + (u64::from(high - low) * u64::from(place) / u64::from(count)) as u32;
            for groups in &starts {
                let taste = if place.is_multiple_of(2) { TASTE } else { taste(&mut self.random) };
                let spare = 0.5 * SPARE_MAX * self.random.unit();
                let mut plan = Plan { width, spare, goal: 0, taste, groups: groups.clone() };
                plans.extend(self.attempt(&mut plan, u64::MAX).map(|texels| (texels, plan)));
            }
        }
        plans.sort_by_key(|(texels, _)| *texels);
        plans.truncate(PLANS_KEPT);
        plans
    }

    /// Changes plans by turns and keeps what is better, or a little worse while there is much work left.
    fn change(&mut self, mut kept: Vec<(u64, Plan)>) {
        while !kept.is_empty() && !self.is_done() {
            let number = self.random.below(kept.len() as u32) as usize;
            let (was, plan) = &kept[number];
            let work_left = 1.0 - (self.skyline.work as f64 / self.work_max as f64).fract();
            let texels_max = *was as f64 * (1.0 + HEAT * f64::from(self.random.unit()) * work_left);
            let mut plan = plan.clone();
            for _ in 0..=self.random.below(CHANGES_MAX) {
                self.change_once(&mut plan);
            }
            if let Some(texels) = self.attempt(&mut plan, texels_max as u64) {
                kept[number] = (texels, plan);
            }
        }
    }

    fn is_done(&self) -> bool {
        let least = self.texels / EMPTY_PART_LEAST;
        let late = (self.texels / UNREAD_PART).saturating_sub(self.goal.spare).max(least);
        let empty_max = match self.skyline.work / self.work_max {
            0 => late.min(self.texels / EMPTY_PART),
            1..LATE_COUNT if self.goal.packing == Packing::Tight => late,
            _ => return true,
        };
        let best = self.best.as_ref().map(|best| product(best.size));
        best.into_iter().chain(self.goal.known).min().is_none_or(|best| best <= self.texels + empty_max)
    }

    fn change_once(&mut self, plan: &mut Plan) {
        let random = &mut self.random;
        let number = random.below(plan.groups.len() as u32) as usize;
        let group = &mut plan.groups[number];
        match random.below(15) {
            0 | 1 => {
                let by = 1 + random.below(1 + plan.width / 64);
                let width =
                    if random.below(2) == 0 { plan.width + by } else { plan.width.saturating_sub(by) };
                plan.width = width.clamp(self.widths[0], self.widths[1]);
            }
            2..=5 => self.join_or_part(&mut plan.groups, number),
            6 => plan.spare = SPARE_MAX * random.unit(),
            7 => plan.taste = taste(random),
            8 | 9 => {
                let most = (plan.width / group.piece.footprint[0]).clamp(1, group.piece.block_count);
                group.columns_max = if random.below(3) == 0 { u32::MAX } else { 1 + random.below(most) };
            }
            kind => group.favor = (random.unit() - 0.5) * if kind % 2 == 0 { 0.4 } else { 1.5 },
        }
    }

    /// Joins a group with another of its size, or parts it in two.
    fn join_or_part(&mut self, groups: &mut Vec<Group>, number: usize) {
        let Group { piece, classes, .. } = &groups[number];
        let is_other = |other: &usize| *other != number && groups[*other].piece.footprint == piece.footprint;
        let others: Vec<usize> = (0..groups.len()).filter(is_other).collect();
        if !others.is_empty() && (classes.len() == 1 || self.random.below(2) == 0) {
            let other = others[self.random.below(others.len() as u32) as usize];
            let all = classes.iter().chain(&groups[other].classes).copied().collect();
            groups[number] = Group::new(self.pieces, all);
            groups.swap_remove(other);
            return;
        }
        let (one, other): (Vec<usize>, Vec<usize>) = classes.iter().partition(|_| self.random.below(2) == 0);
        if !one.is_empty() && !other.is_empty() {
            groups[number] = Group::new(self.pieces, one);
            groups.push(Group::new(self.pieces, other));
        }
    }
}

fn product([width, height]: [u32; 2]) -> u64 {
    u64::from(width) * u64::from(height)
}

/// One of the weights that are tried for each.
fn taste(random: &mut Random) -> Taste {
    let mut weight = |usual: f32| usual * WEIGHTS[random.below(WEIGHTS.len() as u32) as usize];
    Taste {
        lost: weight(TASTE.lost),
        over: weight(TASTE.over),
        full_width: weight(TASTE.full_width),
        as_high: TASTE.as_high.map(&mut weight),
        large: weight(TASTE.large),
    }
}
