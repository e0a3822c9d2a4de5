//! One level set out by a plan: grids come one after the other to the lowest place that is left.
//!
//! What is taken has a skyline: steps of some width up to some height. On its lowest step comes the grid that fits best there
//! (best-fit skyline packing, Burke et al. 2004), with as many columns as fit best: a grid of blocks may be wide
//! and low, or narrow and high. A last row that is not full is a lower step, on which others stand.

/// Blocks of one size, which a level may set out in any number of columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Of a block, texels.
    pub footprint: [u32; 2],
    pub block_count: u32,
}

impl Piece {
    pub fn texels(&self) -> u64 {
        self.footprint.map(u64::from).iter().product::<u64>() * u64::from(self.block_count)
    }

    fn rows(&self, columns: u32) -> u32 {
        self.block_count.div_ceil(columns)
    }
}

/// Classes whose blocks stand in one grid, one after the other.
#[derive(Clone, Debug)]
pub struct Group {
    pub piece: Piece,
    pub classes: Vec<usize>,
    /// How much earlier than others it comes.
    pub favor: f32,
    pub columns_max: u32,
}

/// What a grid at a place is worth, as shares of its texels where nothing else is said.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Taste {
    /// Texels beside or above it that nothing else fits into.
    pub lost: f32,
    /// Texels above the goal.
    pub over: f32,
    /// It fills the step's width.
    pub full_width: f32,
    /// It ends as high as what stands left of it, or right of it.
    pub as_high: [f32; 2],
    /// By the square root of its share of all texels: large ones first, small ones fill up.
    pub large: f32,
}

/// How a level is set out.
#[derive(Clone, Debug)]
pub struct Plan {
    pub width: u32,
    /// What is left empty at most, as a share, if grids keep to the goal.
    pub spare: f32,
    /// The height that grids should keep to.
    pub goal: u32,
    pub taste: Taste,
    pub groups: Vec<Group>,
}

/// A group at its place.
#[derive(Clone, Copy, Debug)]
pub struct Put {
    pub group: usize,
    pub columns: u32,
    pub origin: [u32; 2],
}

/// A step of the skyline, up to the next one's `x`.
#[derive(Clone, Copy, Debug)]
struct Step {
    x: u32,
    y: u32,
}

/// The lowest step and what is around it.
struct Gap {
    x: u32,
    y: u32,
    width: u32,
    /// How much higher it is to the left and to the right.
    walls: [u32; 2],
}

/// The least block sides among the groups that are left.
struct Least {
    width: u32,
    /// The group that has it, and the least width of the others.
    group: usize,
    other_width: u32,
    height: u32,
}

struct Choice {
    cost: f32,
    group: usize,
    columns: u32,
    is_right: bool,
}

/// Higher than any image.
const FAR: u32 = 1 << 30;

#[derive(Debug, Default)]
pub struct Skyline {
    steps: Vec<Step>,
    /// Where the groups stand.
    pub puts: Vec<Put>,
    left: Vec<usize>,
    /// By group: what comes off its cost wherever it stands.
    bonus: Vec<f32>,
    /// Grids that were looked at.
    pub work: u64,
}

impl Skyline {
    /// Sets out all groups; the height, if it is at most `height_max`.
    pub fn fill(&mut self, plan: &Plan, height_max: u32) -> Option<u32> {
        self.start(plan);
        let mut top = 0;
        while !self.left.is_empty() {
            let (number, gap) = self.lowest(plan.width);
            match self.best(plan, &gap) {
                Some(choice) => {
                    top = top.max(self.put(plan, number, &gap, &choice));
                    self.left.retain(|&group| group != choice.group);
                }
                None => {
                    self.steps[number].y += gap.walls[0].min(gap.walls[1]);
                    self.steps.dedup_by_key(|step| step.y);
                }
            }
            if top > height_max || self.steps[0].y >= FAR {
                return None;
            }
        }
        Some(top)
    }

    fn start(&mut self, plan: &Plan) {
        self.steps.clear();
        self.steps.push(Step { x: 0, y: 0 });
        self.puts.clear();
        let texels = |group: &Group| group.piece.texels() as f32;
        let all: f32 = plan.groups.iter().map(texels).sum();
        let bonus = |group: &Group| plan.taste.large * (texels(group) / all).sqrt() + group.favor;
        self.bonus.clear();
        self.bonus.extend(plan.groups.iter().map(bonus));
        self.left.clear();
        self.left.extend(0..plan.groups.len());
        self.left.sort_by(|&a, &b| self.bonus[b].total_cmp(&self.bonus[a]));
    }

    /// The lowest step's number, and its gap.
    fn lowest(&self, width: u32) -> (usize, Gap) {
        let number = (0..self.steps.len()).min_by_key(|&number| self.steps[number].y).unwrap_or(0);
        let Step { x, y } = self.steps[number];
        let next = self.steps.get(number + 1);
        let before = number.checked_sub(1).map_or(FAR, |before| self.steps[before].y - y);
        let after = next.map_or(FAR, |step| step.y - y);
        (number, Gap { x, y, width: next.map_or(width, |step| step.x) - x, walls: [before, after] })
    }

    /// The grid that costs least on a gap.
    fn best(&mut self, plan: &Plan, gap: &Gap) -> Option<Choice> {
        let least = self.least(plan);
        let taste = &plan.taste;
        let most_bonus = taste.full_width + taste.as_high[0] + taste.as_high[1];
        let mut best: Option<Choice> = None;
        for &group in &self.left {
            let bonus = self.bonus[group];
            // Those that follow have less of it still.
            if best.as_ref().is_some_and(|best| -bonus - most_bonus >= best.cost) {
                break;
            }
            self.work += 1;
            for columns in columns(&plan.groups[group], gap, plan.goal).into_iter().flatten() {
                self.work += 1;
                let (cost, is_right) = cost(plan, group, columns, gap, &least);
                if best.as_ref().is_none_or(|best| cost - bonus < best.cost) {
                    best = Some(Choice { cost: cost - bonus, group, columns, is_right });
                }
            }
        }
        best
    }

    fn least(&self, plan: &Plan) -> Least {
        let mut least = Least { width: FAR, group: usize::MAX, other_width: FAR, height: FAR };
        for &group in &self.left {
            let [width, height] = plan.groups[group].piece.footprint;
            least.height = least.height.min(height);
            if width < least.width {
                least = Least { width, group, other_width: least.width, ..least };
            } else {
                least.other_width = least.other_width.min(width);
            }
        }
        least
    }

    /// Places a grid; its upper end.
    fn put(&mut self, plan: &Plan, number: usize, gap: &Gap, choice: &Choice) -> u32 {
        let &Choice { group, columns, is_right, .. } = choice;
        let piece = plan.groups[group].piece;
        let [width, height] = piece.footprint;
        let end = gap.x + gap.width;
        let x = if is_right { end - columns * width } else { gap.x };
        self.puts.push(Put { group, columns, origin: [x, gap.y] });
        let rows = piece.rows(columns);
        let in_last = piece.block_count - (rows - 1) * columns;
        let top = gap.y + rows * height;
        let new = [
            (x > gap.x).then_some(Step { x: gap.x, y: gap.y }),
            Some(Step { x, y: top }),
            (in_last < columns).then_some(Step { x: x + in_last * width, y: top - height }),
            (x + columns * width < end).then_some(Step { x: x + columns * width, y: gap.y }),
        ];
        self.steps.splice(number..number + 1, new.into_iter().flatten());
        self.steps.dedup_by_key(|step| step.y);
        top
    }
}

/// Numbers of columns with which a group may stand on a gap: the most, as few as need no more rows, and those that end as
/// high as what stands beside it, or at the goal.
fn columns(group: &Group, gap: &Gap, goal: u32) -> [Option<u32>; 5] {
    let piece = &group.piece;
    let [width, height] = piece.footprint;
    let most = (gap.width / width).min(piece.block_count).min(group.columns_max);
    if most == 0 || u64::from(piece.rows(most)) * u64::from(height) > u64::from(FAR) {
        return [None; 5];
    }
    let least_rows = piece.rows(most);
    let even = Some(piece.block_count.div_ceil(least_rows)).filter(|&columns| columns < most);
    let up_to = |extent: u32| {
        let rows = extent / height;
        (rows > least_rows && extent < FAR).then(|| piece.block_count.div_ceil(rows))
    };
    let [left, right] = gap.walls;
    [Some(most), even, up_to(left), up_to(right), up_to(goal.saturating_sub(gap.y))]
}

/// What a grid costs on a gap, without its group's bonus, and whether it stands at the right end.
fn cost(plan: &Plan, group: usize, columns: u32, gap: &Gap, least: &Least) -> (f32, bool) {
    let piece = &plan.groups[group].piece;
    let [width, height] = piece.footprint;
    let taste = &plan.taste;
    let rows = piece.rows(columns);
    let high = rows * height;
    let free = gap.width - columns * width;
    let row_width = (piece.block_count - (rows - 1) * columns) * width;
    let notch = columns * width - row_width;
    let other_width = if least.group == group { least.other_width } else { least.width };
    let texels = |width: u32, height: u32| width as f32 * height as f32;
    let mut lost = 0.0;
    if free > 0 && free < other_width {
        lost += texels(free, high.min(gap.walls[0].max(gap.walls[1])));
    }
    if free > 0 && notch > 0 && notch < other_width {
        lost += texels(notch, height);
    }
    let under = plan.goal.saturating_sub(gap.y + high);
    if under < least.height {
        lost += texels(row_width, under);
    }
    let over = texels(row_width, (gap.y + high).saturating_sub(plan.goal));
    let mut cost = (taste.lost * lost + taste.over * over) / piece.texels() as f32;
    let is_left_high = high == gap.walls[0];
    let is_right_high = high - if notch > 0 { height } else { 0 } == gap.walls[1];
    if free == 0 {
        cost -= taste.full_width;
    }
    if is_left_high {
        cost -= taste.as_high[0];
    }
    if is_right_high && free == 0 {
        cost -= taste.as_high[1];
    }
    let is_right = free > 0 && (is_right_high || gap.walls[1] > gap.walls[0] && !is_left_high);
    (cost, is_right)
}
