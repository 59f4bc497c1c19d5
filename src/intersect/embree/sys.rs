//! The generated bindings, and packets of 1, 4, 8 and 16 rays behind one trait.
#![allow(
    missing_docs,
    non_camel_case_types,
    non_snake_case,
    non_upper_case_globals,
    dead_code,
    clippy::all,
    unused_qualifications,
    clippy::undocumented_unsafe_blocks,
    reason = "generated from the C header"
)]

use std::ffi::{c_int, c_void};

use super::super::proxy::ProxyRay;

include!(concat!(env!("OUT_DIR"), "/embree.rs"));

/// A packet of rays as the library takes it.
pub trait Packet: Default {
    /// Number of rays.
    const WIDTH: usize;

    /// Sets ray `i`, which the callbacks will know as `number`.
    fn set(&mut self, i: usize, number: usize, ray: &ProxyRay, reach: f32);

    /// Traces the first `n` rays.
    ///
    /// # Safety
    /// `scene` must be committed, `payload` must be what the callbacks of its geometries expect.
    unsafe fn intersect(&mut self, n: usize, scene: RTCScene, payload: *mut c_void, coherent: c_int);
}

/// One ray.
#[derive(Default)]
pub struct One(RTCRayHit);

impl Packet for One {
    const WIDTH: usize = 1;

    fn set(&mut self, _: usize, _: usize, ray: &ProxyRay, reach: f32) {
        super::write_ray(&mut self.0, ray, reach);
    }

    unsafe fn intersect(&mut self, _: usize, scene: RTCScene, payload: *mut c_void, coherent: c_int) {
        self.0.hit.geomID = u32::MAX;
        // SAFETY: the caller's promise; the struct has the layout of the installed header.
        unsafe { gonio_intersect1(scene, &mut self.0, payload, coherent) };
    }
}

macro_rules! packet {
    ($name:ident, $width:literal, $rays:ident, $call:ident) => {
        /// A packet.
        #[derive(Default)]
        pub struct $name {
            rays: $rays,
            valid: Valid<$width>,
        }

        impl Packet for $name {
            const WIDTH: usize = $width;

            fn set(&mut self, i: usize, number: usize, ray: &ProxyRay, reach: f32) {
                let r = &mut self.rays.ray;
                [r.org_x[i], r.org_y[i], r.org_z[i]] = ray.origin;
                [r.dir_x[i], r.dir_y[i], r.dir_z[i]] = ray.dir;
                r.tnear[i] = 0.0;
                r.tfar[i] = reach;
                r.time[i] = 0.0;
                r.mask[i] = u32::MAX;
                r.id[i] = number as u32;
                r.flags[i] = 0;
            }

            unsafe fn intersect(&mut self, n: usize, scene: RTCScene, payload: *mut c_void, coherent: c_int) {
                self.rays.hit.geomID = [u32::MAX; $width];
                self.valid.0 = std::array::from_fn(|i| if i < n { -1 } else { 0 });
                // SAFETY: the caller's promise; the struct has the layout of the installed header, and `valid`
                // the alignment Embree asks for.
                unsafe { $call(self.valid.0.as_ptr(), scene, &mut self.rays, payload, coherent) };
            }
        }
    };
}

/// Which rays of a packet are active: -1 or 0.
#[repr(C, align(64))]
pub struct Valid<const N: usize>([c_int; N]);

impl<const N: usize> Default for Valid<N> {
    fn default() -> Self {
        Self([0; N])
    }
}

packet!(Four, 4, RTCRayHit4, gonio_intersect4);
packet!(Eight, 8, RTCRayHit8, gonio_intersect8);
packet!(Sixteen, 16, RTCRayHit16, gonio_intersect16);

/// One ray inside a packet of any width: Embree lays a packet out as arrays, one per field, in the order of
/// [`RTCRay`].
pub struct Lane {
    rays: *mut f32,
    lanes: usize,
    lane: usize,
}

impl Lane {
    const TFAR: usize = std::mem::offset_of!(RTCRay, tfar) / 4;
    const ID: usize = std::mem::offset_of!(RTCRay, id) / 4;

    /// Lane `lane` of a packet of `lanes` rays.
    ///
    /// # Safety
    /// `rays` must point to such a packet, which nobody else uses while this lives.
    pub unsafe fn new(rays: *mut RTCRayHitN, lanes: usize, lane: usize) -> Self {
        Self { rays: rays.cast(), lanes, lane }
    }

    /// The number given to the ray by [`Packet::set`].
    pub fn number(&self) -> usize {
        // SAFETY: `new` promises the packet; ids are 32 bits wide, like floats.
        unsafe { *self.rays.add(Self::ID * self.lanes + self.lane).cast::<u32>() as usize }
    }

    /// Ends the ray at `reach`.
    pub fn shorten(&mut self, reach: f32) {
        // SAFETY: `new` promises the packet.
        unsafe { *self.rays.add(Self::TFAR * self.lanes + self.lane) = reach };
    }
}
