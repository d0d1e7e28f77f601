//! Fill-reducing elimination order: approximate minimum degree on a quotient graph, optionally constrained to groups.
//!
//! An eliminated variable becomes an *element*: the clique of its remaining neighbours. Sums over elements bound the degrees from above.
//! Elements inside a newer one are absorbed. Variables with equal neighbourhoods are merged.
//! Source: Amestoy, Davis, Duff, *An approximate minimum degree ordering algorithm*, SIAM J. Matrix Anal. Appl. 17, 1996;
//! groups as in the constrained variant that iSAM2 uses (Kaess and others, IJRR 31, 2012, section 3.4).
//!
//! Cost: nearly linear in the number of edges for pose graphs. The worst case is edges times variables.

/// Undirected graph over variables `0..len`. One array holds all neighbours.
#[derive(Clone, Debug, Default)]
pub struct Adjacency {
    starts: Vec<u32>,
    neighbours: Vec<u32>,
}

impl Adjacency {
    /// From the variables of each factor: every pair of them is an edge. Duplicates are allowed.
    pub fn from_cliques<'a>(len: usize, cliques: impl Iterator<Item = &'a [u32]> + Clone) -> Self {
        let mut starts = vec![0_u32; len + 1];
        for clique in cliques.clone() {
            for &variable in clique {
                starts[variable as usize + 1] += clique.len() as u32 - 1;
            }
        }
        for index in 0..len {
            starts[index + 1] += starts[index];
        }
        let mut cursor = starts.clone();
        let mut neighbours = vec![0; starts[len] as usize];
        for clique in cliques {
            for &variable in clique {
                for &other in clique.iter().filter(|&&other| other != variable) {
                    neighbours[cursor[variable as usize] as usize] = other;
                    cursor[variable as usize] += 1;
                }
            }
        }
        // A clique that names a variable twice leaves gaps behind the cursor. Gaps and duplicates are removed.
        let mut compact = Self { starts: vec![0], neighbours: Vec::with_capacity(neighbours.len()) };
        for index in 0..len {
            let list = &mut neighbours[starts[index] as usize..cursor[index] as usize];
            list.sort_unstable();
            let begin = compact.neighbours.len();
            for &other in list.iter() {
                if compact.neighbours.len() == begin || compact.neighbours.last() != Some(&other) {
                    compact.neighbours.push(other);
                }
            }
            compact.starts.push(compact.neighbours.len() as u32);
        }
        compact
    }

    /// Number of variables.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Neighbours of a variable, ascending.
    pub fn of(&self, variable: usize) -> &[u32] {
        &self.neighbours[self.starts[variable] as usize..self.starts[variable + 1] as usize]
    }
}

const NONE: u32 = u32::MAX;

/// The elimination order. All variables of a lower group come before those of a higher one. An empty slice means one group.
pub fn minimum_degree(graph: &Adjacency, groups: &[u8]) -> Vec<u32> {
    let mut state = State::new(graph, groups);
    let mut order = Vec::with_capacity(graph.len());
    while let Some(pivot) = state.queue.pop() {
        state.eliminate(pivot as usize, &mut order);
    }
    order
}

/// The quotient graph.
struct State {
    /// Neighbouring variables of each variable whose edge no element covers.
    variables: Vec<Vec<u32>>,
    /// Elements of each variable.
    elements: Vec<Vec<u32>>,
    /// Variables of each element. Empty once it is absorbed.
    element_variables: Vec<Vec<u32>>,
    element_weight: Vec<u32>,
    /// Number of variables that a variable represents. 0 once it is eliminated or merged.
    weight: Vec<u32>,
    /// Linked list of the variables merged into each one, with its tail.
    next_merged: Vec<u32>,
    last_merged: Vec<u32>,
    group: Vec<u8>,
    queue: DegreeQueue,
    remaining: u32,
    mark: Vec<u32>,
    stamp: u32,
    /// Weight of an element outside the newest element. Valid where `outside_stamp` equals the pivot.
    outside: Vec<u32>,
    outside_stamp: Vec<u32>,
    hashes: Vec<(u64, u32)>,
}

impl State {
    fn new(graph: &Adjacency, groups: &[u8]) -> Self {
        let len = graph.len();
        let group: Vec<u8> = if groups.is_empty() { vec![0; len] } else { groups.to_vec() };
        let mut queue = DegreeQueue::new(len, group.iter().copied().max().unwrap_or(0));
        for variable in (0..len).rev() {
            queue.insert(variable as u32, group[variable], graph.of(variable).len() as u32);
        }
        Self {
            variables: (0..len).map(|variable| graph.of(variable).to_vec()).collect(),
            elements: vec![Vec::new(); len],
            element_variables: vec![Vec::new(); len],
            element_weight: vec![0; len],
            weight: vec![1; len],
            next_merged: vec![NONE; len],
            last_merged: (0..len as u32).collect(),
            group,
            queue,
            remaining: len as u32,
            mark: vec![0; len],
            stamp: 0,
            outside: vec![0; len],
            outside_stamp: vec![NONE; len],
            hashes: Vec::new(),
        }
    }

    fn eliminate(&mut self, pivot: usize, order: &mut Vec<u32>) {
        let mut front = self.new_element(pivot);
        self.remaining -= self.weight[pivot];
        self.weigh_outside(pivot, &front);
        self.emit(pivot, order);
        for index in 0..front.len() {
            let variable = front[index] as usize;
            if self.update(variable, pivot) && self.group[variable] == self.group[pivot] {
                // All its neighbours are in the pivot's clique, so eliminating it now adds no fill.
                self.remaining -= self.weight[variable];
                self.emit(variable, order);
            }
        }
        front.retain(|&variable| self.weight[variable as usize] > 0);
        self.merge_equals(&front);
        front.retain(|&variable| self.weight[variable as usize] > 0);
        let weight: u32 = front.iter().map(|&variable| self.weight[variable as usize]).sum();
        for &variable in &front {
            let own = self.weight[variable as usize];
            // `update` left the degree outside the front. Merging may have reduced the front's weight.
            let degree = (self.outside[variable as usize] + weight - own).min(self.remaining - own);
            self.queue.insert(variable, self.group[variable as usize], degree);
        }
        self.element_weight[pivot] = weight;
        self.element_variables[pivot] = front;
    }

    /// The clique of the pivot's neighbours. It absorbs the elements of the pivot.
    fn new_element(&mut self, pivot: usize) -> Vec<u32> {
        self.stamp += 1;
        self.mark[pivot] = self.stamp;
        let mut front = Vec::new();
        let mut sources = vec![std::mem::take(&mut self.variables[pivot])];
        for element in std::mem::take(&mut self.elements[pivot]) {
            sources.push(std::mem::take(&mut self.element_variables[element as usize]));
            self.element_weight[element as usize] = 0;
        }
        for variable in sources.into_iter().flatten() {
            let index = variable as usize;
            if self.weight[index] > 0 && self.mark[index] != self.stamp {
                self.mark[index] = self.stamp;
                front.push(variable);
                self.queue.remove(variable);
            }
        }
        front
    }

    /// Computes the weight outside the front of every element that touches the front.
    fn weigh_outside(&mut self, pivot: usize, front: &[u32]) {
        for &variable in front {
            for &element in &self.elements[variable as usize] {
                let element = element as usize;
                if self.element_weight[element] == 0 {
                    continue;
                }
                if self.outside_stamp[element] != pivot as u32 {
                    self.outside_stamp[element] = pivot as u32;
                    self.outside[element] = self.element_weight[element];
                }
                self.outside[element] -= self.weight[variable as usize];
            }
        }
    }

    /// Updates the lists of a variable of the front and stores its degree outside the front in `outside`. Returns true if it has no neighbour
    /// outside.
    fn update(&mut self, variable: usize, pivot: usize) -> bool {
        let mut degree = 0_u32;
        let mut elements = std::mem::take(&mut self.elements[variable]);
        elements.retain(|&element| {
            let element = element as usize;
            if self.element_weight[element] == 0 {
                return false;
            }
            if self.outside[element] == 0 {
                // The element lies inside the new one.
                self.element_weight[element] = 0;
                self.element_variables[element] = Vec::new();
                return false;
            }
            degree += self.outside[element];
            true
        });
        let mut variables = std::mem::take(&mut self.variables[variable]);
        variables.retain(|&other| {
            let keep = self.weight[other as usize] > 0 && self.mark[other as usize] != self.stamp;
            if keep {
                degree += self.weight[other as usize];
            }
            keep
        });
        let alone = elements.is_empty() && variables.is_empty();
        elements.push(pivot as u32);
        self.elements[variable] = elements;
        self.variables[variable] = variables;
        // `outside` serves elements and variables with the same numbers. A variable of the front is not an element yet.
        self.outside[variable] = degree;
        alone
    }

    /// Merges variables of the front that have the same neighbours.
    fn merge_equals(&mut self, front: &[u32]) {
        let mut hashes = std::mem::take(&mut self.hashes);
        hashes.clear();
        for &variable in front {
            let lists = self.variables[variable as usize].iter().chain(&self.elements[variable as usize]);
            hashes.push((lists.map(|&other| u64::from(other)).sum(), variable));
        }
        hashes.sort_unstable();
        for first in 0..hashes.len() {
            let (hash, kept) = hashes[first];
            if self.weight[kept as usize] == 0 || hashes.get(first + 1).is_none_or(|next| next.0 != hash) {
                continue;
            }
            self.stamp += 1;
            for &other in self.variables[kept as usize].iter().chain(&self.elements[kept as usize]) {
                self.mark[other as usize] = self.stamp;
            }
            for &(_, other) in hashes[first + 1..].iter().take_while(|next| next.0 == hash) {
                if self.weight[other as usize] > 0 && self.same_lists(kept as usize, other as usize) {
                    self.merge(kept as usize, other as usize);
                }
            }
        }
        self.hashes = hashes;
    }

    /// Whether `other` has the same lists as `kept`, whose entries are marked.
    fn same_lists(&self, kept: usize, other: usize) -> bool {
        self.group[kept] == self.group[other]
            && self.variables[kept].len() == self.variables[other].len()
            && self.elements[kept].len() == self.elements[other].len()
            && self.variables[other]
                .iter()
                .chain(&self.elements[other])
                .all(|&neighbour| self.mark[neighbour as usize] == self.stamp)
    }

    fn merge(&mut self, kept: usize, other: usize) {
        self.weight[kept] += self.weight[other];
        self.weight[other] = 0;
        let tail = self.last_merged[kept] as usize;
        self.next_merged[tail] = other as u32;
        self.last_merged[kept] = self.last_merged[other];
        self.variables[other] = Vec::new();
        self.elements[other] = Vec::new();
    }

    /// Appends a variable and all variables merged into it to the order.
    fn emit(&mut self, variable: usize, order: &mut Vec<u32>) {
        self.weight[variable] = 0;
        let mut member = variable as u32;
        while member != NONE {
            order.push(member);
            member = self.next_merged[member as usize];
        }
    }
}

/// Variables by group, then by degree. Among equals the last inserted comes first.
struct DegreeQueue {
    degrees: usize,
    heads: Vec<u32>,
    next: Vec<u32>,
    previous: Vec<u32>,
    /// Bucket of each variable, or `NONE`.
    bucket: Vec<u32>,
    lowest: usize,
}

impl DegreeQueue {
    fn new(len: usize, last_group: u8) -> Self {
        let buckets = (len + 1) * (usize::from(last_group) + 1);
        Self {
            degrees: len + 1,
            heads: vec![NONE; buckets],
            next: vec![NONE; len],
            previous: vec![NONE; len],
            bucket: vec![NONE; len],
            lowest: buckets,
        }
    }

    fn insert(&mut self, variable: u32, group: u8, degree: u32) {
        let bucket = usize::from(group) * self.degrees + degree as usize;
        let head = self.heads[bucket];
        self.next[variable as usize] = head;
        self.previous[variable as usize] = NONE;
        if head != NONE {
            self.previous[head as usize] = variable;
        }
        self.heads[bucket] = variable;
        self.bucket[variable as usize] = bucket as u32;
        self.lowest = self.lowest.min(bucket);
    }

    fn remove(&mut self, variable: u32) {
        let index = variable as usize;
        let bucket = std::mem::replace(&mut self.bucket[index], NONE);
        if bucket == NONE {
            return;
        }
        let (previous, next) = (self.previous[index], self.next[index]);
        if previous == NONE {
            self.heads[bucket as usize] = next;
        } else {
            self.next[previous as usize] = next;
        }
        if next != NONE {
            self.previous[next as usize] = previous;
        }
    }

    fn pop(&mut self) -> Option<u32> {
        while self.lowest < self.heads.len() {
            let variable = self.heads[self.lowest];
            if variable != NONE {
                self.remove(variable);
                return Some(variable);
            }
            self.lowest += 1;
        }
        None
    }
}
