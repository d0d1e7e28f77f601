use super::*;

/// One row per point: x, y, z as f32 and one more field.
fn table(name: &str, scalar: ScalarType, rows: &[([f32; 3], Vec<u8>)]) -> PointTable<'static> {
    let mut fields: Vec<PointField> = ["x", "y", "z"]
        .iter()
        .enumerate()
        .map(|(i, name)| PointField {
            name: (*name).into(),
            offset: 4 * i,
            scalar: ScalarType::F32,
            count: 1,
        })
        .collect();
    fields.push(PointField { name: name.into(), offset: 12, scalar, count: 1 });
    let data: Vec<u8> = rows
        .iter()
        .flat_map(|(xyz, extra)| xyz.iter().flat_map(|c| c.to_le_bytes()).chain(extra.iter().copied()))
        .collect();
    PointTable::new(fields, 12 + scalar.size(), rows.len(), false, data.into()).unwrap()
}

fn offsets(name: &str, scalar: ScalarType, values: &[Vec<u8>], stamp: Option<Stamp>) -> (Stamp, Vec<i32>) {
    let rows: Vec<_> = values.iter().map(|bytes| ([1.0, 2.0, 3.0], bytes.clone())).collect();
    let (scan, _) = table(name, scalar, &rows).to_scan(stamp).unwrap();
    (scan.stamp, scan.offset_ns)
}

#[test]
fn every_makers_point_time_becomes_nanoseconds() {
    let stamp = Some(Stamp::from_parts(1_700_000_000, 0));
    let floats = |values: [f32; 2]| values.map(|v| v.to_le_bytes().to_vec());
    let doubles = |values: [f64; 2]| values.map(|v| v.to_le_bytes().to_vec());
    let u32s = |values: [u32; 2]| values.map(|v| v.to_le_bytes().to_vec());

    assert_eq!(offsets("t", ScalarType::U32, &u32s([7, 99_000_000]), stamp).1, [7, 99_000_000], "Ouster");
    assert_eq!(offsets("offset_time", ScalarType::U32, &u32s([0, 5]), stamp).1, [0, 5], "Livox");
    assert_eq!(
        offsets("time", ScalarType::F32, &floats([-0.0625, 0.0]), stamp).1,
        [-62_500_000, 0],
        "Velodyne"
    );
    let hesai = offsets("timestamp", ScalarType::F64, &doubles([1.7e9, 1.7e9 + 0.0625]), stamp);
    assert_eq!(hesai.1, [0, 62_500_000], "Hesai");
    let nanos = offsets("timestamp", ScalarType::F64, &doubles([1.7e18, 1.7e18 + 62_500_096.0]), stamp);
    assert_eq!(nanos.1, [0, 62_500_096], "Livox driver 2");
    assert_eq!(offsets("time", ScalarType::F32, &floats([0.0, 62_500.0]), stamp).1, [0, 62_500_000], "µs");
    let alone = offsets("timestamp", ScalarType::F64, &doubles([1.7e9 + 0.25, 1.7e9]), None);
    assert_eq!(alone, (Stamp::from_parts(1_700_000_000, 0), vec![250_000_000, 0]), "no message stamp");
}

#[test]
fn absolute_times_of_another_clock_count_from_their_own_start() {
    let rows = [100.25f64, 100.5].map(|s| ([1.0, 0.0, 0.0], (s + 1e9).to_le_bytes().to_vec()));
    let table = table("timestamp", ScalarType::F64, &rows);
    let (scan, report) = table.to_scan(Some(Stamp::from_parts(1_700_000_000, 0))).unwrap();
    assert!(report.clock_mismatch);
    assert_eq!(scan.offset_ns, [0, 250_000_000]);
}

#[test]
fn points_without_a_return_are_dropped_from_every_column_and_counted() {
    let row = |x: f32, t: u32| ([x, 0.0, 0.0], t.to_le_bytes().to_vec());
    let table = table("t", ScalarType::U32, &[row(1.0, 1), row(f32::NAN, 2), row(0.0, 3), row(4.0, 4)]);
    let (scan, report) = table.to_scan(None).unwrap();
    assert_eq!(scan.xyz, [[1.0, 0.0, 0.0], [4.0, 0.0, 0.0]]);
    assert_eq!(scan.offset_ns, [1, 4]);
    assert_eq!(report.dropped, Dropped { non_finite: 1, zero_range: 1 });
}

#[test]
fn any_order_type_endianness_and_padding_is_read() {
    // z as big-endian f64, then padding, then y as i16, x as f32; two rows of one point, 8 bytes row padding.
    let mut data = Vec::new();
    for (x, y, z) in [(1.5f32, -2i16, 3.25f64), (4.5, 5, 6.0)] {
        data.extend(z.to_be_bytes());
        data.extend([0xaa; 2]);
        data.extend(y.to_be_bytes());
        data.extend(x.to_be_bytes());
        data.extend([0xbb; 8]);
    }
    let field = |name: &str, offset, scalar| PointField { name: name.into(), offset, scalar, count: 1 };
    let fields = vec![
        field("Z", 0, ScalarType::F64),
        field("Y", 10, ScalarType::I16),
        field("X", 12, ScalarType::F32),
    ];
    let table = PointTable::organised(fields, 16, 24, 1, 2, true, data.into()).unwrap();
    assert_eq!(table.positions().unwrap(), [[1.5, -2.0, 3.25], [4.5, 5.0, 6.0]]);
}

#[test]
fn tables_that_reach_beyond_their_data_are_refused() {
    let field = |offset| PointField { name: "x".into(), offset, scalar: ScalarType::F32, count: 1 };
    let make = |step, width, height, row, offset| {
        PointTable::organised(vec![field(offset)], step, row, width, height, false, vec![0; 64].into())
    };
    assert!(make(16, 4, 1, 64, 0).is_ok());
    assert!(make(16, 5, 1, 80, 0).is_err());
    assert!(make(16, 4, 1, 64, 13).is_err(), "field beyond its point");
    assert!(make(16, usize::MAX, usize::MAX, usize::MAX, 0).is_err());
    assert!(make(16, 2, 2, 16, 0).is_err(), "rows overlap");
    assert!(PointTable::new(vec![], 0, 1000, false, vec![].into()).is_err(), "points without bytes");
}

#[test]
fn billions_of_rows_without_points_take_no_time() {
    let field = |(number, name): (usize, &str)| PointField {
        name: name.to_owned(),
        offset: 4 * number,
        scalar: ScalarType::F32,
        count: 1,
    };
    let fields: Vec<PointField> = ["x", "y", "z", "intensity"].into_iter().enumerate().map(field).collect();
    let table = PointTable::organised(fields, 16, 0, 0, u32::MAX as usize, false, Vec::new().into()).unwrap();
    assert!(table.is_empty() && table.to_scan(None).unwrap().0.xyz.is_empty());
}
