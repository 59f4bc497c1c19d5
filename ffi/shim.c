#include "shim.h"

/* Embree 3 takes a context, Embree 4 arguments that point to one; both are prepared by inline functions that no
   library exports. That difference ends in this file. */
#if GONIO_EMBREE_MAJOR == 4

#define GONIO_PREPARE                                                                     \
    struct gonio_context context;                                                         \
    struct RTCIntersectArguments args;                                                    \
    rtcInitRayQueryContext(&context.embree);                                              \
    rtcInitIntersectArguments(&args);                                                     \
    context.payload = payload;                                                            \
    args.context = &context.embree;                                                       \
    args.flags = coherent ? RTC_RAY_QUERY_FLAG_COHERENT : RTC_RAY_QUERY_FLAG_INCOHERENT;  \
    args.feature_mask = RTC_FEATURE_FLAG_USER_GEOMETRY

#define GONIO_CALL(call, ...) call(__VA_ARGS__, rays, &args)

#else

#define GONIO_PREPARE                                                                                        \
    struct gonio_context context;                                                                            \
    rtcInitIntersectContext(&context.embree);                                                                \
    context.payload = payload;                                                                               \
    context.embree.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT

#define GONIO_CALL(call, ...) call(__VA_ARGS__, &context.embree, rays)

#endif

void gonio_intersect1(RTCScene scene, struct RTCRayHit *rays, void *payload, int coherent)
{
    GONIO_PREPARE;
    GONIO_CALL(rtcIntersect1, scene);
}

void gonio_intersect4(const int *valid, RTCScene scene, struct RTCRayHit4 *rays, void *payload, int coherent)
{
    GONIO_PREPARE;
    GONIO_CALL(rtcIntersect4, valid, scene);
}

void gonio_intersect8(const int *valid, RTCScene scene, struct RTCRayHit8 *rays, void *payload, int coherent)
{
    GONIO_PREPARE;
    GONIO_CALL(rtcIntersect8, valid, scene);
}

void gonio_intersect16(const int *valid, RTCScene scene, struct RTCRayHit16 *rays, void *payload, int coherent)
{
    GONIO_PREPARE;
    GONIO_CALL(rtcIntersect16, valid, scene);
}

size_t gonio_sizeof_rayhit16(void)
{
    return sizeof(struct RTCRayHit16);
}
