#include "shim.h"

/* What Embree does by itself, for benches: its own spheres, triangles or cones in single precision. */

RTCScene gonio_bare_new(int kind, const float *vertices, size_t count, const unsigned *faces, size_t face_count)
{
    static const enum RTCGeometryType types[] = {RTC_GEOMETRY_TYPE_SPHERE_POINT, RTC_GEOMETRY_TYPE_TRIANGLE,
                                                 RTC_GEOMETRY_TYPE_CONE_LINEAR_CURVE};
    RTCDevice device = rtcNewDevice(NULL);
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, types[kind]);
    size_t width = kind == 1 ? 3 : 4, used = kind == 1 ? 3 : 1;
    float *v = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                       kind == 1 ? RTC_FORMAT_FLOAT3 : RTC_FORMAT_FLOAT4, width * sizeof(float), count);
    for (size_t i = 0; i < width * count; i++)
        v[i] = vertices[i];
    if (kind != 0) {
        unsigned *f = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                                              kind == 1 ? RTC_FORMAT_UINT3 : RTC_FORMAT_UINT, used * sizeof(unsigned),
                                              face_count);
        for (size_t i = 0; i < used * face_count; i++)
            f[i] = faces[i];
    }
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    rtcReleaseDevice(device);
    return scene;
}

/* Rays are origin, near, direction and far, 8 floats each; returns how many hit something. */
size_t gonio_bare_shoot(RTCScene scene, const float *rays, size_t count)
{
    size_t hits = 0;
    for (size_t i = 0; i < count; i++, rays += 8) {
        struct RTCRayHit one;
        one.ray.org_x = rays[0];
        one.ray.org_y = rays[1];
        one.ray.org_z = rays[2];
        one.ray.tnear = rays[3];
        one.ray.dir_x = rays[4];
        one.ray.dir_y = rays[5];
        one.ray.dir_z = rays[6];
        one.ray.tfar = rays[7];
        one.ray.time = 0;
        one.ray.mask = -1;
        one.ray.id = 0;
        one.ray.flags = 0;
        one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        gonio_intersect1(scene, &one, NULL, 0);
        hits += one.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

void gonio_bare_free(RTCScene scene)
{
    rtcReleaseScene(scene);
}
