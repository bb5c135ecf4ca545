// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/stream/light_field_stream.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <random>

#include "common/base/errors.h"
#include "reconstructor/light_field_file/page_tables.h"

namespace sheen {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint32_t kFormat = 2, kNothingKnown = UINT32_MAX;
constexpr std::size_t kBitsPerWord = 32;
constexpr std::size_t kMostEyes = 8;  // each has its view coefficients in memory
constexpr std::size_t kMostBatches = 64;
constexpr std::size_t kMostMapsBytes = std::size_t{128} << 20;  // beyond, a patch is packed for each desk

template <typename Numbers>
void append(const Numbers& numbers, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(*numbers.data()));
}
void append(std::initializer_list<std::uint32_t> numbers, std::string& bytes) {
  bytes.append(reinterpret_cast<const char*>(numbers.begin()), numbers.size() * sizeof(std::uint32_t));
}
std::uint32_t bits_of(float value) {
  return std::bit_cast<std::uint32_t>(value);
}
std::uint32_t count(std::size_t n) {
  return static_cast<std::uint32_t>(n);
}

bool known(const std::shared_ptr<const PatchSnapshot>& patch) {
  return patch && patch->rank() > 0;
}

/// Of the views of all its vertices: a coefficient per term.
Eigen::VectorXf mean_of(const PatchSnapshot& patch) {
  Eigen::VectorXf sum = Eigen::VectorXf::Zero(patch.rank());
  for (const VertexInterpolant& vertex : patch.vertices) sum += vertex.mean;
  return sum / static_cast<float>(patch.vertices.size());
}

/// Nearly edge-on ones do: the desk computes in single precision.
bool faces(const Mesh& mesh, std::size_t triangle, const Eigen::Vector3f& eye) {
  constexpr float kEdgeOn = -1e-3f;  // cosine
  const Eigen::Vector3f normal = mesh.area_normal(triangle), to_eye = eye - mesh.corner(triangle, 0);
  return normal.dot(to_eye) >= kEdgeOn * normal.norm() * to_eye.norm();
}

/// Not one that a desk has of a program that ran before.
std::uint32_t first_scene() {
  return std::random_device()() >> 1 | 1;
}

}  // namespace

LightFieldStream::LightFieldStream(std::size_t answer_bytes) : answer_bytes_(answer_bytes), scene_(first_scene()) {}

void LightFieldStream::follow(std::shared_ptr<const ModelSnapshot> model, Clock::time_point since) {
  auto snapshot = std::dynamic_pointer_cast<const SurfaceLightFieldSnapshot>(std::move(model));
  if (!snapshot) throw Error("what desks are to draw is not a surface light field");
  if (snapshot == snapshot_) return;
  if (!snapshot_ || snapshot->shared_mesh() != snapshot_->shared_mesh() ||
      snapshot->shared_maps() != snapshot_->shared_maps() || snapshot->patch_count() != patches_.size())
    enter(*snapshot);
  snapshot_ = std::move(snapshot);
  eyes_.clear();
  const std::uint32_t before = changes_;
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    const std::shared_ptr<const PatchSnapshot>& patch = snapshot_->patches()[i];
    if (patch == patches_[i]) continue;
    patches_[i] = patch;
    changed_at_[i] = ++changes_;
    maps_bytes_ -= maps_[i].texels.size();
    maps_[i] = {};
  }
  if (changes_ > before) batches_.push_back({changes_, since});
  if (batches_.size() > kMostBatches) batches_.pop_front();
}

/// Nothing of it is known to any desk.
void LightFieldStream::enter(const SurfaceLightFieldSnapshot& snapshot) {
  ++scene_;
  changes_ = 0;
  batches_.clear();
  patches_.assign(snapshot.patch_count(), nullptr);
  changed_at_.assign(snapshot.patch_count(), 0);
  maps_.assign(snapshot.patch_count(), {});
  maps_bytes_ = 0;
  samples_.assign(snapshot.patch_count(), 0);
  first_column_.assign(snapshot.patch_count() + 1, 0);
  patch_of_.clear();
  edges_.clear();
  for (std::size_t t = 0; t < snapshot.mesh().triangles.size(); ++t) {
    const TrianglePlace place = snapshot.place(t);
    patch_of_.push_back(place.patch);
    samples_[place.patch] += count(static_cast<std::size_t>(lattice_samples(snapshot.maps().resolution(t))));
    for (const std::uint32_t column : place.columns)
      first_column_[place.patch + 1] = std::max(first_column_[place.patch + 1], column + 1);
  }
}

std::string LightFieldStream::scene() {
  const Mesh& mesh = snapshot_->mesh();
  if (edges_.empty()) edges_ = edge_table(mesh);
  std::string bytes;
  append({kFormat, scene_, count(mesh.vertices.size()), count(mesh.triangles.size()), count(patches_.size()),
          first_column_.back(), count(snapshot_->maps().total_samples()), count(edges_.size())},
         bytes);
  append(scene_table(mesh, snapshot_->cameras(), snapshot_->brightest()), bytes);
  append(mesh.vertices, bytes);
  append(mesh.triangles, bytes);
  append(edges_, bytes);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const TrianglePlace place = snapshot_->place(t);
    append({place.patch, place.first_sample, count(static_cast<std::size_t>(snapshot_->maps().resolution(t)))}, bytes);
    append(place.columns, bytes);
  }
  for (std::size_t i = 0; i < patches_.size(); ++i) append({samples_[i], first_column_[i]}, bytes);
  return bytes;
}

std::string LightFieldStream::changes_for(const DeskState& desk) {
  std::string answer;
  if (desk.scene != scene_) {
    append({kFormat, scene_, 0, 1, 0, 0, 0, 0, 0}, answer);
    return answer;
  }
  std::vector<std::size_t> lacking;
  for (std::size_t i = 0; i < patches_.size(); ++i)
    if (changed_at_[i] > desk.changes) lacking.push_back(i);
  std::sort(lacking.begin(), lacking.end(),
            [this](std::size_t a, std::size_t b) { return changed_at_[a] < changed_at_[b]; });

  Eye* const eye = desk.moved || !lacking.empty() ? &eye_at(desk.eye) : nullptr;
  if (!lacking.empty()) find(lacking, *eye);
  std::string maps;
  std::size_t sent = 0;
  for (; sent < lacking.size() && (sent == 0 || maps.size() < answer_bytes_); ++sent)
    add_patch(lacking[sent], *eye, maps);
  const bool more = sent < lacking.size(), seen = desk.moved && !more;
  const std::vector<float> cameras = more || sent == 0 ? std::vector<float>() : camera_table(snapshot_->cameras());
  append({kFormat, scene_, sent == 0 ? desk.changes : changed_at_[lacking[sent - 1]], more ? 1u : 0u, count(sent),
          seen ? 1u : 0u, count(snapshot_->cameras().size()) * (cameras.empty() ? 0u : 1u),
          bits_of(snapshot_->exposure().at(desk.eye)), sent == 0 ? 0 : waited_ms(desk.changes)},
         answer);
  if (seen) answer += seen_by(desk, *eye);
  answer += maps;
  append(cameras, answer);
  return answer;
}

/// For how long there has been a change that a desk lacks which has so many.
std::uint32_t LightFieldStream::waited_ms(std::uint32_t changes) const {
  const auto oldest =
      std::find_if(batches_.begin(), batches_.end(), [changes](const Batch& batch) { return batch.changes > changes; });
  if (oldest == batches_.end()) return 0;
  return static_cast<std::uint32_t>((Clock::now() - oldest->since) / std::chrono::milliseconds(1));
}

/// Of the patches that the desk has already: which of them face the eye, and their coefficients.
std::string LightFieldStream::seen_by(const DeskState& desk, Eye& eye) const {
  std::vector<std::size_t> held;
  for (std::size_t i = 0; i < patches_.size(); ++i)
    if (eye.faced[i] && changed_at_[i] <= desk.changes && known(patches_[i])) held.push_back(i);
  find(held, eye);
  std::vector<std::uint32_t> bits((patches_.size() + kBitsPerWord - 1) / kBitsPerWord);
  std::string coefficients, bytes;
  for (const std::size_t i : held) {
    bits[i / kBitsPerWord] |= 1u << i % kBitsPerWord;
    append(of_patch(eye, i), coefficients);
  }
  append(bits, bytes);
  return bytes + coefficients;
}

LightFieldStream::Eye& LightFieldStream::eye_at(const Eigen::Vector3d& place) {
  const auto asked = std::find_if(eyes_.begin(), eyes_.end(), [&](const Eye& known) { return known.place == place; });
  if (asked != eyes_.end()) return *asked;
  if (eyes_.size() == kMostEyes) eyes_.erase(eyes_.begin());
  Eye eye{.place = place,
          .faced = std::vector<bool>(patches_.size()),
          .found = std::vector<bool>(patches_.size()),
          .coefficients = {}};
  const Mesh& mesh = snapshot_->mesh();
  for (std::size_t t = 0; t < patch_of_.size(); ++t)
    if (!eye.faced[patch_of_[t]] && faces(mesh, t, place.cast<float>())) eye.faced[patch_of_[t]] = true;
  return eyes_.emplace_back(std::move(eye));
}

void LightFieldStream::find(const std::vector<std::size_t>& wanted, Eye& eye) const {
  std::vector<bool> missing(patches_.size());
  bool none = true;
  for (const std::size_t i : wanted) {
    if (!eye.faced[i] || eye.found[i]) continue;
    missing[i] = eye.found[i] = true;
    none = false;
  }
  if (none) return;
  // On this thread alone: all others are the capture's.
  tbb::task_arena(1).execute([&] {
    const Eigen::MatrixXf found = snapshot_->coefficients_for(eye.place, missing);
    if (eye.coefficients.size() == 0) eye.coefficients.setZero(found.rows(), found.cols());
    eye.coefficients += found;
  });
}

Eigen::MatrixXf LightFieldStream::of_patch(const Eye& eye, std::size_t index) const {
  const Eigen::Index columns = first_column_[index + 1] - first_column_[index];
  if (!eye.faced[index]) return mean_of(*patches_[index]).replicate(1, columns);
  return eye.coefficients.block(0, first_column_[index], patches_[index]->rank(), columns);
}

LightFieldStream::Maps LightFieldStream::maps_of(std::size_t index) const {
  Maps maps;
  std::vector<std::uint8_t> means(kPageTexelBytes * samples_[index]);
  if (!known(patches_[index])) {
    append({count(index), kNothingKnown, 0, 0}, maps.head);
    append(means, maps.texels);
    return maps;
  }
  const PatchSnapshot& patch = *patches_[index];
  const Eigen::MatrixXf colours = patch.colours();
  const Eigen::VectorXf mean = mean_of(patch);
  std::vector<SampleState> states;
  for (std::size_t s = 0; s < samples_[index]; ++s) states.push_back(patch.state(static_cast<int>(s)));
  const MeanRange range = pack_means(colours * mean, states, means.data());

  const auto terms = static_cast<std::size_t>(patch.rank());
  std::vector<std::uint8_t> texels(means.size() * terms);
  std::vector<float> amounts;
  for (std::size_t k = 0; k < terms; ++k)
    amounts.push_back(amount_per_coefficient(
        pack_term(colours.col(static_cast<Eigen::Index>(k)), terms, texels.data() + kPageTexelBytes * k)));
  append({count(index), count(terms), bits_of(range.low), bits_of(range.width)}, maps.head);
  append(mean, maps.head);
  append(amounts, maps.head);
  append(means, maps.texels);
  append(texels, maps.texels);
  return maps;
}

void LightFieldStream::add_patch(std::size_t index, const Eye& eye, std::string& answer) {
  Maps made;
  Maps* maps = &maps_[index];
  if (maps->head.empty()) {
    made = maps_of(index);
    if (maps_bytes_ + made.texels.size() <= kMostMapsBytes) {
      maps_bytes_ += made.texels.size();
      *maps = std::move(made);
    } else {
      maps = &made;
    }
  }
  answer += maps->head;
  if (known(patches_[index])) append(of_patch(eye, index), answer);
  answer += maps->texels;
}

}  // namespace sheen
