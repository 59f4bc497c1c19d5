//! Backend: Intel Embree, every primitive as user geometry.
//!
//! Embree walks its hierarchy of single-precision boxes and calls back with candidates; the callback asks
//! [`Primitives`] in double precision and shortens the ray to the best crossing so far. Native geometry is not
//! used: its distances are single precision, and its maintainers report rays that miss at corners or meet an
//! edge twice.
//!
//! This folder and `ffi/` are the only places with `unsafe` code.
#![allow(unsafe_code, reason = "the C library is called here and nowhere else")]

mod bare;
mod sys;

pub use bare::Bare;

use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use self::sys::{RTCBoundsFunctionArguments, RTCIntersectFunctionNArguments, RTCRayHit};
use super::Coherence;
use super::proxy::{Patches, Proxy, ProxyRay};
use crate::geometry::{All, Kind, Nearest, PrimId, Primitives, Query, Sink};

/// Version of the header this build was made with, as `3.13.5`.
pub fn header_version() -> String {
    dotted(sys::RTC_VERSION)
}

fn dotted(version: u32) -> String {
    format!("{}.{}.{}", version / 10_000, version / 100 % 100, version % 100)
}

/// Rays per call of the library.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// One ray.
    One,
    /// A packet of four.
    Four,
    /// A packet of eight.
    Eight,
    /// A packet of sixteen.
    Sixteen,
}

impl Width {
    /// What measures best for user geometry (`benches/intersect.rs`): packets only pay while rays run together,
    /// because packets of user geometry never fall back to single rays.
    pub fn best(coherence: Coherence) -> Self {
        match coherence {
            Coherence::Coherent => Self::Sixteen,
            Coherence::Scattered => Self::One,
        }
    }
}

/// A device of the library; one per scene.
struct Device {
    raw: sys::RTCDevice,
    errors: Box<Mutex<Vec<String>>>,
}

impl Device {
    fn new() -> Result<Self, String> {
        // SAFETY: a null configuration asks for the defaults.
        let raw = unsafe { sys::rtcNewDevice(ptr::null()) };
        if raw.is_null() {
            // SAFETY: with a null device this returns the error of the calling thread's last rtcNewDevice.
            let code = unsafe { sys::rtcGetDeviceError(ptr::null_mut()) };
            return Err(format!("Embree cannot make a device (error {code})"));
        }
        let errors = Box::<Mutex<Vec<String>>>::default();
        let device = Self { raw, errors };
        let sink: *const Mutex<Vec<String>> = &*device.errors;
        // SAFETY: the box outlives the device: both are dropped together, the device first (`Drop`).
        unsafe { sys::rtcSetDeviceErrorFunction(raw, Some(note_error), sink.cast_mut().cast()) };
        device.check_version()?;
        Ok(device)
    }

    /// The library that runs must be the one whose header was read: struct layouts differ between versions.
    fn check_version(&self) -> Result<(), String> {
        // SAFETY: the device is valid.
        let running = unsafe { sys::rtcGetDeviceProperty(self.raw, sys::RTC_DEVICE_PROPERTY_VERSION) } as u32;
        let built = sys::RTC_VERSION;
        // Within version 3 the layout is fixed; in 4 it depends on options that follow the minor version.
        let same = if built / 10_000 == 3 { running / 10_000 == 3 } else { running / 100 == built / 100 };
        // SAFETY: returns a constant.
        let compiled = unsafe { sys::gonio_sizeof_rayhit16() };
        if compiled != size_of::<sys::RTCRayHit16>() {
            return Err(
                "the Embree header was bound wrongly: its structs differ in size; build again from clean".into()
            );
        }
        if same {
            return Ok(());
        }
        Err(format!(
            "the running Embree is {}, but this program was built with the header of {}; build it again",
            dotted(running),
            dotted(built)
        ))
    }

    /// Errors the library reported since the last call.
    fn check(&self) -> Result<(), String> {
        let mut errors = self.errors.lock().unwrap_or_else(PoisonError::into_inner);
        if errors.is_empty() {
            return Ok(());
        }
        Err(format!("Embree: {}", errors.drain(..).collect::<Vec<_>>().join("; ")))
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        // SAFETY: made by rtcNewDevice and released once; scenes hold their own reference.
        unsafe { sys::rtcReleaseDevice(self.raw) };
    }
}

/// Called by Embree on any thread.
unsafe extern "C" fn note_error(sink: *mut c_void, code: sys::RTCError, text: *const c_char) {
    // SAFETY: `Device::new` passed a pointer to a Mutex that lives as long as the device.
    let sink = unsafe { &*sink.cast::<Mutex<Vec<String>>>() };
    let text = if text.is_null() {
        format!("error {code}")
    } else {
        // SAFETY: Embree passes a C string that is valid during the call.
        unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned()
    };
    sink.lock().unwrap_or_else(PoisonError::into_inner).push(text);
}

/// What the callbacks of one geometry need. Its address is handed to Embree.
struct Geometry {
    primitives: Arc<Primitives>,
    proxy: Proxy,
    kind: Kind,
    first: u32,
    /// What Embree takes for one primitive, if these are triangles.
    patches: Patches,
}

impl Geometry {
    /// Primitives as Embree sees them.
    fn count(&self) -> usize {
        if self.kind == Kind::Triangle { self.patches.count() } else { self.primitives.count(self.kind) }
    }

    /// Box of one.
    fn bounds(&self, index: u32) -> [[f32; 3]; 2] {
        if self.kind == Kind::Triangle {
            return self.proxy.around(self.patches.bounds(&self.primitives, index as usize));
        }
        self.proxy.bounds(&self.primitives, PrimId(self.first + index))
    }
}

/// What the callbacks need of one call: the questions, and where answers go.
struct Payload {
    queries: *const Query,
    nearest: *mut Nearest,
    /// By number of the ray in the packet: its query and answer, and the distance by which its start was moved.
    slots: [usize; 16],
    skipped: [f64; 16],
    /// Not null: collect every crossing of query 0 instead.
    all: *mut All,
}

/// A committed scene.
pub struct Embree {
    raw: sys::RTCScene,
    proxy: Proxy,
    // Dropped after `raw` is released (see `Drop`): Embree holds their addresses.
    _geometries: Box<[Geometry]>,
    _device: Device,
}

// SAFETY: Embree allows queries of a committed scene from any thread; nothing here is changed after `new`.
unsafe impl Send for Embree {}
// SAFETY: as above.
unsafe impl Sync for Embree {}

impl Embree {
    /// Builds and commits a scene.
    ///
    /// # Errors
    /// What the library reports.
    pub fn new(primitives: &Arc<Primitives>, proxy: Proxy) -> Result<Self, String> {
        let device = Device::new()?;
        let geometries: Box<[_]> = Kind::BOUNDED
            .into_iter()
            .filter(|&kind| primitives.count(kind) > 0)
            .map(|kind| Geometry {
                primitives: primitives.clone(),
                proxy,
                kind,
                first: primitives.first(kind).0,
                patches: if kind == Kind::Triangle { Patches::new(primitives) } else { Patches::default() },
            })
            .collect();
        // SAFETY: the device is valid.
        let raw = unsafe { sys::rtcNewScene(device.raw) };
        device.check()?;
        let scene = Self { raw, proxy, _geometries: geometries, _device: device };
        // SAFETY: the scene is valid and not committed.
        unsafe {
            sys::rtcSetSceneFlags(raw, sys::RTC_SCENE_FLAG_ROBUST);
            sys::rtcSetSceneBuildQuality(raw, sys::RTC_BUILD_QUALITY_MEDIUM);
        }
        for (id, geometry) in scene._geometries.iter().enumerate() {
            scene.attach(geometry, id as u32);
        }
        // SAFETY: all geometries are committed.
        unsafe { sys::rtcCommitScene(raw) };
        scene._device.check()?;
        Ok(scene)
    }

    fn attach(&self, geometry: &Geometry, id: u32) {
        let intersect = match geometry.kind {
            Kind::Triangle => intersect::<{ Kind::Triangle as u8 }>,
            Kind::Sphere => intersect::<{ Kind::Sphere as u8 }>,
            Kind::Cylinder => intersect::<{ Kind::Cylinder as u8 }>,
            Kind::Cuboid | Kind::Layer => intersect::<{ Kind::Cuboid as u8 }>,
        };
        let user: *const Geometry = geometry;
        // SAFETY: device and scene are valid; `geometry` is boxed and outlives the scene; the callbacks have the
        // signatures Embree asks for and take the user pointer for what it is.
        unsafe {
            let raw = sys::rtcNewGeometry(self._device.raw, sys::RTC_GEOMETRY_TYPE_USER);
            sys::rtcSetGeometryUserPrimitiveCount(raw, geometry.count() as u32);
            sys::rtcSetGeometryUserData(raw, user.cast_mut().cast());
            sys::rtcSetGeometryBoundsFunction(raw, Some(bounds), ptr::null_mut());
            sys::rtcSetGeometryIntersectFunction(raw, Some(intersect));
            sys::rtcCommitGeometry(raw);
            sys::rtcAttachGeometryByID(self.raw, raw, id);
            sys::rtcReleaseGeometry(raw);
        }
    }

    /// Completes the nearest interfaces of some of `queries`.
    pub fn nearest(&self, queries: &[Query], which: &[usize], coherence: Coherence, answers: &mut [Nearest]) {
        self.nearest_by(Width::best(coherence), queries, which, coherence, answers);
    }

    /// The same with a given packet width.
    ///
    /// # Panics
    /// When a number in `which` is out of range.
    pub fn nearest_by(
        &self,
        width: Width,
        queries: &[Query],
        which: &[usize],
        coherence: Coherence,
        answers: &mut [Nearest],
    ) {
        if self._geometries.is_empty() {
            return;
        }
        match width {
            Width::One => self.packets::<sys::One>(queries, which, coherence, answers),
            Width::Four => self.packets::<sys::Four>(queries, which, coherence, answers),
            Width::Eight => self.packets::<sys::Eight>(queries, which, coherence, answers),
            Width::Sixteen => self.packets::<sys::Sixteen>(queries, which, coherence, answers),
        }
    }

    fn packets<P: sys::Packet>(
        &self,
        queries: &[Query],
        which: &[usize],
        coherence: Coherence,
        answers: &mut [Nearest],
    ) {
        let coherent = c_int::from(coherence == Coherence::Coherent);
        let mut packet = P::default();
        let mut payload = Payload {
            queries: queries.as_ptr(),
            nearest: answers.as_mut_ptr(),
            slots: [0; 16],
            skipped: [0.0; 16],
            all: ptr::null_mut(),
        };
        for slots in which.chunks(P::WIDTH) {
            for (i, &slot) in slots.iter().enumerate() {
                let ray = self.proxy.ray(&queries[slot].ray);
                packet.set(i, i, &ray, self.proxy.reach(answers[slot].horizon(), &ray));
                payload.slots[i] = slot;
                payload.skipped[i] = ray.skipped;
            }
            // Embree's packets may call back for inactive rays: let those be the first ray once more.
            let first = self.proxy.ray(&queries[slots[0]].ray);
            for i in slots.len()..P::WIDTH {
                packet.set(i, 0, &first, -1.0);
            }
            // SAFETY: the scene is committed; the payload and what it points to outlive the call, and each ray of
            // the packet has its query and answer at its slot, both of which were just indexed.
            unsafe { packet.intersect(slots.len(), self.raw, (&raw mut payload).cast(), coherent) };
        }
    }

    /// Adds every crossing up to the limit of `query`.
    pub fn all(&self, query: &Query, found: &mut All) {
        if self._geometries.is_empty() {
            return;
        }
        let ray = self.proxy.ray(&query.ray);
        let mut packet = sys::One::default();
        sys::Packet::set(&mut packet, 0, 0, &ray, self.proxy.reach(query.limit, &ray));
        let mut payload = Payload {
            queries: query,
            nearest: ptr::null_mut(),
            slots: [0; 16],
            skipped: [ray.skipped; 16],
            all: found,
        };
        // SAFETY: as in `packets`, with one ray.
        unsafe { sys::Packet::intersect(&mut packet, 1, self.raw, (&raw mut payload).cast(), 0) };
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: made by rtcNewScene and released once; geometries and device are dropped after this.
        unsafe { sys::rtcReleaseScene(self.raw) };
    }
}

/// Embree asks for the box of a primitive.
unsafe extern "C" fn bounds(args: *const RTCBoundsFunctionArguments) {
    // SAFETY: Embree passes valid arguments; the user pointer is the Geometry of `attach`.
    let (args, geometry) = unsafe { (&*args, &*(*args).geometryUserPtr.cast::<Geometry>()) };
    let [low, high] = geometry.bounds(args.primID);
    // SAFETY: Embree provides the place for the answer.
    let out = unsafe { &mut *args.bounds_o };
    [out.lower_x, out.lower_y, out.lower_z] = low;
    [out.upper_x, out.upper_y, out.upper_z] = high;
}

/// Embree proposes a primitive to a packet of rays. Does not panic: all indices come from the lists that Embree
/// was told about.
unsafe extern "C" fn intersect<const KIND: u8>(args: *const RTCIntersectFunctionNArguments) {
    // SAFETY: Embree passes valid arguments; the user pointer is the Geometry of `attach`, the context the first
    // member of the gonio_context that the shim made, and its payload that of `packets` or `all`.
    let (args, geometry, payload) = unsafe {
        let context = (*args).context.cast::<sys::gonio_context>();
        (&*args, &*(*args).geometryUserPtr.cast::<Geometry>(), &*(*context).payload.cast::<Payload>())
    };
    let lanes = args.N as usize;
    for lane in 0..lanes {
        // SAFETY: `valid` has N entries.
        if unsafe { *args.valid.add(lane) } == 0 {
            continue;
        }
        // SAFETY: `rayhit` is a packet of N rays.
        let mut ray = unsafe { sys::Lane::new(args.rayhit, lanes, lane) };
        let number = ray.number();
        // SAFETY: rays are numbered within the packet; `packets` and `all` put valid slots there.
        unsafe {
            let slot = payload.slots[number];
            let query = &*payload.queries.add(slot);
            if payload.all.is_null() {
                let answer = &mut *payload.nearest.add(slot);
                let horizon = answer.horizon();
                propose::<KIND>(geometry, query, args.primID, answer);
                if answer.horizon() != horizon {
                    ray.shorten(geometry.proxy.reach_after(answer.horizon(), payload.skipped[number]));
                }
            } else {
                propose::<KIND>(geometry, query, args.primID, &mut *payload.all);
            }
        }
    }
}

#[inline]
fn propose<const KIND: u8>(geometry: &Geometry, query: &Query, index: u32, sink: &mut impl Sink) {
    let (i, prim) = (index as usize, PrimId(geometry.first + index));
    match KIND {
        k if k == Kind::Triangle as u8 => {
            for i in geometry.patches.triangles(i) {
                geometry.primitives.propose_triangle(query, i, PrimId(i as u32), sink);
            }
        }
        k if k == Kind::Sphere as u8 => geometry.primitives.propose_sphere(query, i, prim, sink),
        k if k == Kind::Cylinder as u8 => geometry.primitives.propose_cylinder(query, i, prim, sink),
        _ => geometry.primitives.propose_cuboid(query, i, prim, sink),
    }
}

/// Fills one ray of a single-ray packet.
fn write_ray(out: &mut RTCRayHit, ray: &ProxyRay, reach: f32) {
    let [x, y, z] = ray.origin;
    let [dx, dy, dz] = ray.dir;
    out.ray = sys::RTCRay {
        org_x: x,
        org_y: y,
        org_z: z,
        tnear: 0.0,
        dir_x: dx,
        dir_y: dy,
        dir_z: dz,
        time: 0.0,
        tfar: reach,
        mask: u32::MAX,
        id: 0,
        flags: 0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_is_that_of_the_installed_header() {
        // SAFETY: returns a constant.
        let c = unsafe { sys::gonio_sizeof_rayhit16() };
        assert_eq!(size_of::<sys::RTCRayHit16>(), c);
        assert_eq!(align_of::<sys::RTCRayHit16>(), 64);
        match sys::RTC_VERSION {
            // Debian 12.
            31305 => assert_eq!(c, 1280),
            // Debian 13: built with instance arrays, which add a field to each hit.
            40303 => assert_eq!(c, 1344),
            _ => {}
        }
    }
}
