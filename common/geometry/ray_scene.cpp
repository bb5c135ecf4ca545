// SPDX-License-Identifier: Apache-2.0
#include "common/geometry/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <stdexcept>

#include "common/base/errors.h"

namespace sheen {
namespace {

constexpr std::size_t kPacket = 8;

RTCRay embree_ray(const Ray& ray) {
  return {ray.origin.x(),
          ray.origin.y(),
          ray.origin.z(),
          ray.near,
          ray.direction.x(),
          ray.direction.y(),
          ray.direction.z(),
          0,
          ray.far,
          0xffffffffu,
          0,
          0};
}

/// Up to a packet of rays; what is left of it is not valid.
void fill(RTCRay8& to, int* valid, std::span<const Ray> rays) {
  for (std::size_t k = 0; k < kPacket; ++k) {
    const Ray& ray = rays[std::min(k, rays.size() - 1)];
    valid[k] = k < rays.size() ? -1 : 0;
    to.org_x[k] = ray.origin.x();
    to.org_y[k] = ray.origin.y();
    to.org_z[k] = ray.origin.z();
    to.dir_x[k] = ray.direction.x();
    to.dir_y[k] = ray.direction.y();
    to.dir_z[k] = ray.direction.z();
    to.tnear[k] = ray.near;
    to.tfar[k] = ray.far;
    to.time[k] = 0;
    to.mask[k] = 0xffffffffu;
    to.id[k] = to.flags[k] = 0;
  }
}

Hit to_hit(std::uint32_t geometry, std::uint32_t triangle, float distance, float u, float v, const Eigen::Vector3f& n,
           const Eigen::Vector3f& direction) {
  if (geometry == RTC_INVALID_GEOMETRY_ID) return {};
  return {triangle, distance, u, v, n.dot(direction) < 0};
}

}  // namespace

struct RayScene::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;

  explicit Impl(const Mesh& mesh) {
    device = rtcNewDevice(nullptr);  // asked for one thread, Embree would hold all of TBB in the process to one
    if (!device) throw Error("Embree could not be started (error " + std::to_string(rtcGetDeviceError(nullptr)) + ")");
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                                 3 * sizeof(float), mesh.vertices.size()));
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      Eigen::Map<Eigen::Vector3f>(vertices + 3 * i) = mesh.vertices[i];
    auto* triangles = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(Triangle), mesh.triangles.size()));
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) std::copy_n(mesh.triangles[i].data(), 3, triangles + 3 * i);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) {
      release();
      throw Error("Embree could not build the scene of " + std::to_string(mesh.triangles.size()) +
                  " triangles (error " + std::to_string(error) + ")");
    }
  }
  ~Impl() { release(); }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void release() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

RayScene::RayScene(const Mesh& mesh) : impl_(std::make_unique<Impl>(mesh)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

Hit RayScene::intersect(const Ray& ray) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit query{};
  query.ray = embree_ray(ray);
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(impl_->scene, &context, &query);
  return to_hit(query.hit.geomID, query.hit.primID, query.ray.tfar, query.hit.u, query.hit.v,
                {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z}, ray.direction);
}

bool RayScene::occluded(const Ray& ray) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay query = embree_ray(ray);
  rtcOccluded1(impl_->scene, &context, &query);
  return query.tfar < 0;
}

void RayScene::intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
  if (rays.size() != hits.size()) throw std::invalid_argument("RayScene::intersect: as many hits as rays are needed");
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::span<const Ray> packet = rays.subspan(first, std::min(kPacket, rays.size() - first));
    RTCRayHit8 query;
    alignas(32) int valid[kPacket];
    fill(query.ray, valid, packet);
    std::fill_n(query.hit.geomID, kPacket, RTC_INVALID_GEOMETRY_ID);
    std::fill_n(query.hit.instID[0], kPacket, RTC_INVALID_GEOMETRY_ID);
    rtcIntersect8(valid, impl_->scene, &context, &query);
    for (std::size_t k = 0; k < packet.size(); ++k)
      hits[first + k] =
          to_hit(query.hit.geomID[k], query.hit.primID[k], query.ray.tfar[k], query.hit.u[k], query.hit.v[k],
                 {query.hit.Ng_x[k], query.hit.Ng_y[k], query.hit.Ng_z[k]}, packet[k].direction);
  }
}

void RayScene::occluded(std::span<const Ray> rays, std::span<std::uint8_t> blocked) const {
  if (rays.size() != blocked.size()) throw std::invalid_argument("RayScene::occluded: one answer per ray is needed");
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const std::span<const Ray> packet = rays.subspan(first, std::min(kPacket, rays.size() - first));
    RTCRay8 query;
    alignas(32) int valid[kPacket];
    fill(query, valid, packet);
    rtcOccluded8(valid, impl_->scene, &context, &query);
    for (std::size_t k = 0; k < packet.size(); ++k) blocked[first + k] = query.tfar[k] < 0;
  }
}

}  // namespace sheen
