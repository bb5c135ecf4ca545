// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "common/base/errors.h"
#include "reconstructor/models/model_kind.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen::testing {

/// The smallest model that is one: each triangle has the mean linear colour of the pixels that showed it. It is there
/// to show that nothing outside a model's folder knows which model it drives.
struct FlatColourSettings : ModelSettings {
  int pixel_stride = 1;  ///< every Nth pixel of a row and every Nth row are looked at

  const char* kind() const override { return "flat_colour"; }
  std::unique_ptr<ModelSettings> clone() const override { return std::make_unique<FlatColourSettings>(*this); }
  std::vector<SettingKey> keys() override;
  void require_valid() const override;
  int effort_levels() const override { return 2; }  ///< the quicker one looks at a quarter of the pixels
  MemoryNeed memory_need(std::size_t vertices, std::size_t triangles) const override;
  std::unique_ptr<AppearanceModel> make_model(std::shared_ptr<const Mesh> mesh,
                                              std::shared_ptr<const RayScene> scene) const override;
  std::unique_ptr<Baselines> make_baselines(std::shared_ptr<const ModelSnapshot> snapshot,
                                            bool photographs) const override;
};

class FlatColourSnapshot : public ModelSnapshot {
 public:
  FlatColourSnapshot(std::shared_ptr<const Mesh> mesh, std::vector<Eigen::Vector3f> colours, std::vector<bool> seen,
                     std::uint64_t version)
      : mesh_(std::move(mesh)), colours_(std::move(colours)), seen_(std::move(seen)), version_(version) {}

  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;
  const std::shared_ptr<const Mesh>& shared_mesh() const override { return mesh_; }
  std::uint64_t version() const override { return version_; }
  bool empty() const override;
  const std::vector<PosedCamera>& cameras() const override { return cameras_; }
  SnapshotFigures figures() const override;
  std::size_t memory_bytes() const override { return colours_.size() * sizeof(colours_[0]); }
  std::shared_ptr<const ModelSnapshot> filled() const override;
  ViewAdvice advise_next_view(const Eigen::Vector3d& eye) const override;
  std::unique_ptr<Compression> compression(CompressionTarget) const override {
    throw ConfigError("a flat colour is small");
  }
  void save(const std::filesystem::path& folder, const ModelMetadata& metadata,
            const StepsDone& progress) const override;

  const std::vector<Eigen::Vector3f>& colours() const { return colours_; }  ///< per triangle, linear RGB
  bool seen(std::size_t triangle) const { return seen_[triangle]; }

 private:
  std::shared_ptr<const Mesh> mesh_;
  std::vector<Eigen::Vector3f> colours_;
  std::vector<bool> seen_;
  std::uint64_t version_;
  std::vector<PosedCamera> cameras_;  ///< none: it does not ask
};

class FlatColourModel : public AppearanceModel {
 public:
  FlatColourModel(std::shared_ptr<const Mesh> mesh, const FlatColourSettings& settings);

  IngestReport ingest(const Capture& capture) override;
  bool withdraw(const Capture& capture) override;
  bool began_with(const Capture& capture) const override;
  void restart(int effort_level) override;
  std::shared_ptr<const ModelSnapshot> snapshot() override { return flat_snapshot(version_++); }
  std::shared_ptr<const Appearance> constant_colour() const override { return flat_snapshot(version_); }
  const ModelSettings& settings() const override { return settings_; }
  ModelFigures figures() const override;
  MemoryAccount memory(const CaptureSize& image) const override;

 private:
  /// What an image showed: sums of colours and numbers of pixels, per triangle.
  struct Image {
    std::string source_session;
    std::uint64_t sequence = 0;
    std::vector<Eigen::Vector4f> sums;
  };
  std::shared_ptr<const FlatColourSnapshot> flat_snapshot(std::uint64_t version) const;
  Image look(const Capture& capture) const;

  std::shared_ptr<const Mesh> mesh_;
  FlatColourSettings settings_;
  int effort_level_ = 0;
  RayPainter rays_;
  std::vector<Image> images_;
  std::uint64_t version_ = 0;
};

const ModelKind& flat_colour_kind();

}  // namespace sheen::testing
