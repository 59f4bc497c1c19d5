/* What Rust sees of Embree: the installed header, and four calls that are the same for Embree 3 and 4. */
#pragma once

#if GONIO_EMBREE_MAJOR == 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

/* A query context that carries a pointer of ours. Embree hands its first member to the callbacks. */
struct gonio_context {
#if GONIO_EMBREE_MAJOR == 4
    struct RTCRayQueryContext embree;
#else
    struct RTCIntersectContext embree;
#endif
    void *payload;
};

/* Nearest hit of 1, 4, 8 or 16 rays; `coherent` is a hint. `valid` holds -1 (active) or 0 per ray. */
void gonio_intersect1(RTCScene scene, struct RTCRayHit *rays, void *payload, int coherent);
void gonio_intersect4(const int *valid, RTCScene scene, struct RTCRayHit4 *rays, void *payload, int coherent);
void gonio_intersect8(const int *valid, RTCScene scene, struct RTCRayHit8 *rays, void *payload, int coherent);
void gonio_intersect16(const int *valid, RTCScene scene, struct RTCRayHit16 *rays, void *payload, int coherent);

/* Embree by itself: kind 0 are its spheres, 1 its triangles, 2 its cones. Rays have 8 floats: origin, near, direction, far. */
RTCScene gonio_bare_new(int kind, const float *vertices, size_t count, const unsigned *faces, size_t face_count);
size_t gonio_bare_shoot(RTCScene scene, const float *rays, size_t count);
void gonio_bare_free(RTCScene scene);

/* The compiler's view of the packet, to hold against the one generated for Rust. */
size_t gonio_sizeof_rayhit16(void);
