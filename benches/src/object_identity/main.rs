//! Whether objects are known again: views of simulated objects from one side and the other, turned in any direction, compared by box size, by the geometric descriptor and by the learned one; and the
//! training of the latter.

#![allow(clippy::print_stdout, reason = "the table is this program's output")]

mod objects;
mod score;
mod views;

use anyhow::{Context, Result};
use clap::Parser;
use geometry::RngTree;
use object_identity::{
    GeometricDescriptor, ObjectDescriptor, ObjectShape, PointNetwork, TrainingConfig, ViewFeatures, train,
};
use objects::{ShapedObject, boxes, furniture};
use score::{DescribedView, Measure, fitted_model, nearest_share, pair_scores};
use sim::SiteName;
use std::path::PathBuf;
use views::{ObjectView, views};

/// Sites whose furniture the network is trained on, and those that it has not seen.
const TRAINING_SITES: u64 = 40;
const OTHER_SITES: u64 = 20;
/// Random boxes of the training, and of the test.
const TRAINING_BOXES: usize = 150;
const OTHER_BOXES: usize = 60;

/// Whether objects are known again.
///
/// Examples: cargo xtask bench object_identity
///           cargo xtask bench object_identity --train autonomy/object_identity/weights/network-1.bin
///           cargo xtask bench object_identity --fit
#[derive(Parser)]
struct Arguments {
    /// Train the network, and write its weights into this file. The same seed and steps give the same file.
    #[arg(long, value_name = "FILE")]
    train: Option<PathBuf>,
    /// Steps of the training.
    #[arg(long, default_value_t = TrainingConfig::default().steps)]
    steps: usize,
    /// Use the weights of this file instead of those that come with the program.
    #[arg(long, value_name = "FILE")]
    weights: Option<PathBuf>,
    /// Print the models of pairs that fit the objects of the training.
    #[arg(long)]
    fit: bool,
    /// Views of each object.
    #[arg(long, default_value_t = 8)]
    views: usize,
    /// Least number of points of a view.
    #[arg(long, default_value_t = 30)]
    min_points: usize,
    /// Seed of views, boxes and comparisons.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn main() -> Result<()> {
    let arguments = Arguments::parse();
    if let Some(file) = &arguments.train {
        let config =
            TrainingConfig { steps: arguments.steps, seed: arguments.seed, ..TrainingConfig::default() };
        let seen = training_views(&arguments);
        println!("{} objects, {} views", seen.len(), seen.iter().map(Vec::len).sum::<usize>());
        let features: Vec<Vec<ViewFeatures>> = seen
            .iter()
            .map(|views| views.iter().filter_map(|view| ViewFeatures::new(&view.points)).collect())
            .collect();
        let network = train(&features, &config, |step, loss| {
            if step % 250 == 0 {
                println!("step {step}: loss {loss:.3}");
            }
        })
        .context("there are too few objects")?;
        println!("{} weights", network.weights());
        std::fs::write(file, network.to_bytes()).with_context(|| file.display().to_string())?;
        return Ok(());
    }
    let network = match &arguments.weights {
        Some(file) => {
            PointNetwork::from_bytes(&std::fs::read(file).with_context(|| file.display().to_string())?)?
        }
        None => PointNetwork::shipped()?,
    };
    let geometric = GeometricDescriptor::default();
    let methods: [(&str, &dyn ObjectDescriptor); 2] = [("geometric", &geometric), ("learned", &network)];
    if arguments.fit {
        let seen = training_views(&arguments);
        for (name, method) in methods {
            let described = described(&seen, method);
            if name == "geometric" {
                println!("sizes: {:?}", fitted_model(&described, Measure::Sizes, 40_000, 7));
            }
            println!("{name}: {:?}", fitted_model(&described, Measure::Descriptor, 40_000, 7));
        }
        return Ok(());
    }
    let tree = RngTree::new(arguments.seed).child("other views");
    let well_seen = |mut views: Vec<Vec<ObjectView>>| {
        views.iter_mut().for_each(|views| views.retain(|view| view.points.len() >= arguments.min_points));
        views.retain(|views| views.len() > 1);
        views
    };
    let boxes = seen(&boxes(arguments.seed + 1_000, OTHER_BOXES), arguments.views, &tree.child("boxes"));
    let pieces = seen(&furniture(&other_sites()), arguments.views, &tree.child("furniture"));
    let (boxes, pieces) = (well_seen(boxes), well_seen(pieces));
    print_scores("boxes", &boxes, &methods, arguments.seed);
    print_scores("furniture", &pieces, &methods, arguments.seed);
    let all: Vec<Vec<ObjectView>> = pieces.into_iter().chain(boxes).collect();
    print_scores("all", &all, &methods, arguments.seed);
    Ok(())
}

/// Views of the objects of the training.
fn training_views(arguments: &Arguments) -> Vec<Vec<ObjectView>> {
    // B1 and further ones; those of the test are others.
    let sites: Vec<SiteName> =
        std::iter::once(SiteName::B1).chain((1..=TRAINING_SITES).map(SiteName::Generated)).collect();
    let objects: Vec<ShapedObject> =
        furniture(&sites).into_iter().chain(boxes(arguments.seed, TRAINING_BOXES)).collect();
    seen(&objects, arguments.views.max(12), &RngTree::new(arguments.seed).child("training views"))
}

fn other_sites() -> Vec<SiteName> {
    let generated = (1_001..=1_000 + OTHER_SITES).map(SiteName::Generated);
    [SiteName::Torus, SiteName::Plant].into_iter().chain(generated).collect()
}

/// The views of objects, of which each has at least two.
fn seen(objects: &[ShapedObject], count: usize, tree: &RngTree) -> Vec<Vec<ObjectView>> {
    let of_object =
        |(number, object): (usize, &ShapedObject)| views(object, count, &tree.child(&number.to_string()));
    objects.iter().enumerate().map(of_object).filter(|views| views.len() > 1).collect()
}

fn described(views: &[Vec<ObjectView>], method: &dyn ObjectDescriptor) -> Vec<Vec<DescribedView>> {
    let of_view = |object: usize, view: &ObjectView| {
        let descriptor = method.describe(&view.points);
        let shape = ObjectShape { size_m: view.size_m, descriptor };
        DescribedView { object, shape }
    };
    views
        .iter()
        .enumerate()
        .map(|(object, views)| views.iter().map(|view| of_view(object, view)).collect())
        .collect()
}

fn print_scores(name: &str, views: &[Vec<ObjectView>], methods: &[(&str, &dyn ObjectDescriptor)], seed: u64) {
    let count: usize = views.iter().map(Vec::len).sum();
    println!("\n{name}: {} objects, {count} views\n", views.len());
    println!(
        "| method | nearest of 10 | nearest of 50 | with box size, of 10 | of 50 | K-means | wrong | assignment | wrong | mean probability | without limits | wrong |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    let of = |found: usize, all: usize| percent(found as f64 / all.max(1) as f64);
    for (place, (method, descriptor)) in methods.iter().enumerate() {
        let described = described(views, *descriptor);
        let nearest = |measure, others| percent(nearest_share(&described, measure, others, seed));
        let scores = pair_scores(&described, 2_000, seed);
        if place == 0 {
            let plain: Vec<Vec<DescribedView>> =
                described.iter().map(|views| views.iter().map(without_descriptor).collect()).collect();
            let by_size = pair_scores(&plain, 2_000, seed);
            let (by_size, open_by_size) = (by_size.by_assignment, by_size.by_open_assignment);
            println!(
                "| box size, the nearest place of one size | – | – | – | – | – | – | {} | {} | – | – | – |",
                of(scores.by_box.right, scores.by_box.moved),
                of(scores.by_box.wrong, scores.by_box.right + scores.by_box.wrong)
            );
            println!(
                "| box size | {} | {} | – | – | – | – | {} | {} | {} | {} | {} |",
                nearest(Measure::Sizes, 9),
                nearest(Measure::Sizes, 49),
                of(by_size.right, by_size.moved),
                of(by_size.wrong, by_size.right + by_size.wrong),
                percent(by_size.probability / (by_size.right + by_size.wrong).max(1) as f64),
                of(open_by_size.right, open_by_size.moved),
                of(open_by_size.wrong, open_by_size.right + open_by_size.wrong)
            );
        }
        let (clusters, assigned, open) =
            (scores.by_clusters, scores.by_assignment, scores.by_open_assignment);
        println!(
            "| {method} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
            nearest(Measure::Descriptor, 9),
            nearest(Measure::Descriptor, 49),
            nearest(Measure::Likelihood, 9),
            nearest(Measure::Likelihood, 49),
            of(clusters.right, clusters.moved),
            of(clusters.wrong, clusters.right + clusters.wrong),
            of(assigned.right, assigned.moved),
            of(assigned.wrong, assigned.right + assigned.wrong),
            percent(assigned.probability / (assigned.right + assigned.wrong).max(1) as f64),
            of(open.right, open.moved),
            of(open.wrong, open.right + open.wrong)
        );
    }
}

fn without_descriptor(view: &DescribedView) -> DescribedView {
    let shape = ObjectShape { descriptor: None, ..view.shape.clone() };
    DescribedView { shape, ..view.clone() }
}
