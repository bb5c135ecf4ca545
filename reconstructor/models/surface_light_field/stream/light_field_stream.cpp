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

constexpr std::uint32_t kFormat = 1, kNothingKnown = UINT32_MAX;
constexpr std::size_t kBitsPerWord = 32;
constexpr std::size_t kMostEyes = 8;                            // each has its view coefficients in memory
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

bool known(const std::shared_ptr<const SurfacePatch>& patch) {
  return patch && patch->rank() > 0;
}

/// Not one that a desk has of a program that ran before.
std::uint32_t first_scene() {
  return std::random_device()() >> 1 | 1;
}

}  // namespace

LightFieldStream::LightFieldStream(std::size_t answer_bytes) : answer_bytes_(answer_bytes), scene_(first_scene()) {}

void LightFieldStream::follow(std::shared_ptr<const ModelSnapshot> model) {
  auto snapshot = std::dynamic_pointer_cast<const LightFieldSnapshot>(std::move(model));
  if (!snapshot) throw Error("what desks are to draw is not a surface light field");
  if (snapshot == snapshot_) return;
  if (!snapshot_ || snapshot->shared_mesh() != snapshot_->shared_mesh() ||
      snapshot->shared_maps() != snapshot_->shared_maps() || snapshot->patch_count() != patches_.size()) {
    ++scene_;
    changes_ = 0;
    patches_.assign(snapshot->patch_count(), nullptr);
    changed_at_.assign(snapshot->patch_count(), 0);
    maps_.assign(snapshot->patch_count(), {});
    maps_bytes_ = 0;
    samples_.assign(snapshot->patch_count(), 0);
    first_column_.assign(snapshot->patch_count() + 1, 0);
    for (std::size_t t = 0; t < snapshot->mesh().triangles.size(); ++t) {
      const TrianglePlace place = snapshot->place(t);
      samples_[place.patch] += count(static_cast<std::size_t>(lattice_samples(snapshot->maps().resolution(t))));
      for (const std::uint32_t column : place.columns)
        first_column_[place.patch + 1] = std::max(first_column_[place.patch + 1], column + 1);
    }
  }
  snapshot_ = std::move(snapshot);
  eyes_.clear();
  for (std::size_t i = 0; i < patches_.size(); ++i) {
    std::shared_ptr<const SurfacePatch> patch = snapshot_->patch(i);
    if (patch == patches_[i]) continue;
    patches_[i] = std::move(patch);
    changed_at_[i] = ++changes_;
    maps_bytes_ -= maps_[i].texels.size();
    maps_[i] = {};
  }
}

std::string LightFieldStream::scene() {
  const Mesh& mesh = snapshot_->mesh();
  const std::vector<std::uint32_t> edges = edge_table(mesh);
  std::string bytes;
  append({kFormat, scene_, count(mesh.vertices.size()), count(mesh.triangles.size()), count(patches_.size()),
          first_column_.back(), count(snapshot_->maps().total_samples()), count(edges.size())},
         bytes);
  append(scene_table(mesh, snapshot_->cameras(), snapshot_->brightest()), bytes);
  append(mesh.vertices, bytes);
  append(mesh.triangles, bytes);
  append(edges, bytes);
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
    append({kFormat, scene_, 0, 1, 0, 0, 0, 0}, answer);
    return answer;
  }
  std::vector<std::size_t> lacking;
  for (std::size_t i = 0; i < patches_.size(); ++i)
    if (changed_at_[i] > desk.changes) lacking.push_back(i);
  std::sort(lacking.begin(), lacking.end(),
            [this](std::size_t a, std::size_t b) { return changed_at_[a] < changed_at_[b]; });
  const Eigen::MatrixXf* const seen = desk.moved || !lacking.empty() ? &coefficients_from(desk.eye) : nullptr;

  std::string of_eye;
  if (desk.moved) {
    std::vector<std::uint32_t> held((patches_.size() + kBitsPerWord - 1) / kBitsPerWord);
    std::string coefficients;
    for (std::size_t i = 0; i < patches_.size(); ++i) {
      if (changed_at_[i] > desk.changes || !known(patches_[i])) continue;
      held[i / kBitsPerWord] |= 1u << i % kBitsPerWord;
      append(of_patch(*seen, i), coefficients);
    }
    append(held, of_eye);
    of_eye += coefficients;
  }
  std::string maps;
  std::size_t sent = 0;
  for (; sent < lacking.size() && (sent == 0 || maps.size() < answer_bytes_); ++sent)
    add_patch(lacking[sent], *seen, maps);
  const bool more = sent < lacking.size();
  const std::vector<float> cameras = more || sent == 0 ? std::vector<float>() : camera_table(snapshot_->cameras());
  append({kFormat, scene_, sent == 0 ? desk.changes : changed_at_[lacking[sent - 1]], more ? 1u : 0u, count(sent),
          desk.moved ? 1u : 0u, count(snapshot_->cameras().size()) * (cameras.empty() ? 0u : 1u),
          bits_of(snapshot_->exposure().at(desk.eye))},
         answer);
  answer += of_eye;
  answer += maps;
  append(cameras, answer);
  return answer;
}

const Eigen::MatrixXf& LightFieldStream::coefficients_from(const Eigen::Vector3d& eye) {
  const auto asked = std::find_if(eyes_.begin(), eyes_.end(), [&](const Eye& known) { return known.place == eye; });
  if (asked != eyes_.end()) return asked->coefficients;
  if (eyes_.size() == kMostEyes) eyes_.erase(eyes_.begin());
  // On this thread alone: all others are the capture's.
  tbb::task_arena(1).execute([&] { eyes_.push_back({eye, snapshot_->coefficients_for(eye)}); });
  return eyes_.back().coefficients;
}

Eigen::MatrixXf LightFieldStream::of_patch(const Eigen::MatrixXf& coefficients, std::size_t index) const {
  return coefficients.block(0, first_column_[index], patches_[index]->rank(),
                            first_column_[index + 1] - first_column_[index]);
}

LightFieldStream::Maps LightFieldStream::maps_of(std::size_t index, const Eigen::MatrixXf& coefficients) const {
  Maps maps;
  std::vector<std::uint8_t> means(kPageTexelBytes * samples_[index]);
  if (!known(patches_[index])) {
    append({count(index), kNothingKnown, 0, 0}, maps.head);
    append(means, maps.texels);
    return maps;
  }
  const SurfacePatch& patch = *patches_[index];
  const Eigen::MatrixXf colours = patch.colours();
  const Eigen::VectorXf mean = of_patch(coefficients, index).rowwise().mean();
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

void LightFieldStream::add_patch(std::size_t index, const Eigen::MatrixXf& coefficients, std::string& answer) {
  Maps made;
  Maps* maps = &maps_[index];
  if (maps->head.empty()) {
    made = maps_of(index, coefficients);
    if (maps_bytes_ + made.texels.size() <= kMostMapsBytes) {
      maps_bytes_ += made.texels.size();
      *maps = std::move(made);
    } else {
      maps = &made;
    }
  }
  answer += maps->head;
  if (known(patches_[index])) append(of_patch(coefficients, index), answer);
  answer += maps->texels;
}

}  // namespace sheen
