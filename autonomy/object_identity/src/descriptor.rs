//! Descriptors of the shapes of objects.

/// The shape of an object as a short vector. Only descriptors of one name can be compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Descriptor {
    /// Name of the method with its version.
    pub name: String,
    /// Its components, as multiples of 1/127.
    pub values: Vec<i8>,
}

impl Descriptor {
    /// The descriptor with these components; those beyond -1 and 1 are cut off.
    pub(crate) fn new(name: &str, components: impl IntoIterator<Item = f64>) -> Self {
        let whole = |component: f64| (component.clamp(-1.0, 1.0) * 127.0).round() as i8;
        Self { name: name.to_owned(), values: components.into_iter().map(whole).collect() }
    }

    /// Euclidean distance; none between descriptors that cannot be compared.
    pub fn distance(&self, other: &Self) -> Option<f64> {
        let is_comparable = self.name == other.name && self.values.len() == other.values.len();
        let difference = |(a, b): (&i8, &i8)| (f64::from(*a) - f64::from(*b)) / 127.0;
        let squares = || self.values.iter().zip(&other.values).map(difference).map(|x| x * x);
        is_comparable.then(|| squares().sum::<f64>().sqrt())
    }
}

/// A way to describe the shape of an object, the same wherever it stands and whichever way it is turned, also upside down.
pub trait ObjectDescriptor {
    /// Name of the method with its version.
    fn name(&self) -> &str;

    /// The descriptor of an object with these points, metres, in any frame. Their order matters only if there are more than 1,024. None of fewer than 10 points, of points that are not
    /// finite, and of points at one place.
    fn describe(&self, points: &[[f32; 3]]) -> Option<Descriptor>;
}
