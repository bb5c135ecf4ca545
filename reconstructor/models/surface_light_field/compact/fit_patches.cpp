// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/compact/fit_patches.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <span>

#include "reconstructor/light_field_file/grid_geometry.h"
#include "reconstructor/models/surface_light_field/fill_unseen.h"
#include "reconstructor/numerics/symmetric_eigen.h"
#include "reconstructor/numerics/view_kriging.h"
#include "reconstructor/surface/lattice_resampling.h"
#include "reconstructor/surface/nearest_seen.h"

namespace sheen {
namespace {

constexpr float kGreyLevels = 255;
constexpr float kMoved = 2e-3f;  // rad: further from all cameras a view is one that others were merged into

/// Those before maps became coarser: smooth maps cost the file nothing, and a sample has the same weight in all of
/// them.
std::vector<std::uint8_t> resolutions(const SurfaceLightFieldSnapshot& snapshot, const CanonicalMesh& canonical) {
  std::vector<std::uint8_t> resolution;
  for (const std::uint32_t old : canonical.old_triangle)
    resolution.push_back(static_cast<std::uint8_t>(snapshot.maps().filter_resolution(old)));
  return resolution;
}

/// Gives each view of a vertex the camera that it is of, or the nearest one that is left.
std::vector<std::uint16_t> images_of(const Eigen::Matrix3Xf& directions, const Eigen::Matrix3Xf& cameras) {
  struct Pair {
    float cosine;
    Eigen::Index view, camera;
  };
  std::vector<Pair> pairs;
  const Eigen::MatrixXf cosines = directions.transpose() * cameras;
  for (Eigen::Index j = 0; j < directions.cols(); ++j)
    for (Eigen::Index i = 0; i < cameras.cols(); ++i) pairs.push_back({cosines(j, i), j, i});
  std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.cosine > b.cosine; });
  std::vector<std::uint16_t> images(static_cast<std::size_t>(directions.cols()));
  std::vector<bool> given(images.size()), taken(static_cast<std::size_t>(cameras.cols()));
  for (const Pair& pair : pairs) {
    const auto view = static_cast<std::size_t>(pair.view), camera = static_cast<std::size_t>(pair.camera);
    if (given[view] || taken[camera]) continue;
    given[view] = taken[camera] = true;
    images[view] = static_cast<std::uint16_t>(camera);
  }
  return images;
}

std::uint8_t kernel_index(std::vector<ViewKernel>& kernels, const ViewKernel& kernel) {
  const auto found = std::find(kernels.begin(), kernels.end(), kernel);
  if (found == kernels.end()) kernels.push_back(kernel);
  return static_cast<std::uint8_t>(std::find(kernels.begin(), kernels.end(), kernel) - kernels.begin());
}

/// Coefficients of a patch's views, in grey levels, as they went into the kriging: what it says of them with all of the
/// drift, believed or not, and what the nugget kept from being displayed.
Eigen::MatrixXf view_coefficients(const VertexInterpolant& at) {
  const VertexViews& views = *at.views;
  const Eigen::MatrixXf weights = at.weights.unpacked();
  Eigen::MatrixXf coefficients(weights.cols(), views.directions.cols());
  for (Eigen::Index j = 0; j < coefficients.cols(); ++j) {
    const Eigen::Vector3f direction = views.directions.col(j);
    coefficients.col(j) = at.mean + weights.transpose() * covariances(views.kernel, views.directions, direction) +
                          weights.row(j).transpose() * (views.kernel.nugget / views.reliability[j]);
    if (at.drift.size() > 0) coefficients.col(j) += views.reflection->at(direction, views.frame.row(2)) * at.drift;
  }
  return kGreyLevels * coefficients;
}

/// What is displayed in a vertex's own views of values in them: values * (I - Z diag(nugget / reliability)).
Eigen::MatrixXf smoother(const KrigingSystem& system) {
  const Eigen::Index n = system.directions.cols();
  if (n < 2) return Eigen::MatrixXf::Identity(n, n);
  const ViewInterpolant dual =
      krige(system.directions, Eigen::MatrixXf::Identity(n, n), system.reliability, system.kernel, system.drift);
  Eigen::MatrixXf smoother = -dual.weights;
  for (Eigen::Index j = 0; j < n; ++j) smoother.col(j) *= system.kernel.nugget / system.reliability[j];
  smoother.diagonal().array() += 1;
  return smoother;
}

/// Lattice sample of the old triangle for each of the new, whose corner 0 is the old one's corner `first`.
std::vector<int> rotated_samples(int resolution, int first) {
  std::vector<int> old(static_cast<std::size_t>(lattice_samples(resolution)));
  for (int i = 0; i < resolution; ++i)
    for (int j = 0; i + j < resolution; ++j) {
      const int weight[3] = {resolution - 1 - i - j, i, j};  // of the new corners
      int of_old[3];
      for (int c = 0; c < 3; ++c) of_old[(c + first) % 3] = weight[c];
      old[static_cast<std::size_t>(lattice_index(resolution, i, j))] = lattice_index(resolution, of_old[1], of_old[2]);
    }
  return old;
}

class PatchFit {
 public:
  PatchFit(const SurfaceLightFieldSnapshot& snapshot, const CanonicalMesh& canonical, double least_rms,
           std::size_t patch_triangles)
      : filled_(fill_unseen(snapshot)),
        snapshot_(snapshot),
        canonical_(canonical),
        least_square_(least_rms * least_rms),
        patch_triangles_(patch_triangles) {}

  CompactModel fit() {
    const Mesh& mesh = *canonical_.mesh;
    model_.mesh = canonical_.mesh;
    model_.grid = std::make_shared<GridMesh>(canonical_.grid);
    model_.maps = std::make_shared<MapLayout>(resolutions(snapshot_, canonical_));
    model_.patch_triangles = patch_triangles_;
    model_.shapes = cut_into_patches(mesh, *model_.maps, {.triangles = patch_triangles_});
    model_.cameras = snapshot_.cameras();
    model_.eyes = grid_eyes(model_.cameras, canonical_.grid);
    model_.exposure = snapshot_.exposure();
    model_.vertices.resize(mesh.vertices.size());
    describe_grown();
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) describe_vertex(v);
    find_sources(model_);
    normals_ = vertex_normals(mesh);
    model_.patches.resize(model_.shapes.patches.size());
    brightest_.resize(model_.patches.size(), 0);
    tbb::parallel_for(std::size_t{0}, model_.patches.size(), [&](std::size_t i) { fit_patch(i); });
    // What an image that shows little of a patch would have shown of the rest is a guess without a bound.
    for (const float colour : brightest_)
      model_.brightest = std::max(model_.brightest, std::min(colour, CompactModel::kMostBrightest));
    return std::move(model_);
  }

 private:
  Eigen::Matrix3Xf camera_directions(const Eigen::Vector3f& place) const {
    Eigen::Matrix3Xf directions(3, static_cast<Eigen::Index>(model_.cameras.size()));
    for (std::size_t i = 0; i < model_.cameras.size(); ++i)
      directions.col(static_cast<Eigen::Index>(i)) =
          (camera_centre(model_.cameras[i].camera_from_object).cast<float>() - place).normalized();
    return directions;
  }

  void describe_grown() {
    grown_.resize(snapshot_.patches().size());
    tbb::parallel_for(std::size_t{0}, grown_.size(), [&](std::size_t p) {
      const PatchSnapshot* patch = snapshot_.patches()[p].get();
      if (!patch || !patch->seen() || model_.cameras.empty()) return;
      const VertexInterpolant& first = patch->vertices.front();
      const Eigen::Vector3f& place = snapshot_.mesh().vertices[snapshot_.shapes().patches[p].vertices.front()];
      grown_[p] = images_of(first.views->directions, camera_directions(place));
    });
  }

  /// The views of all patches round a vertex.
  void describe_vertex(std::size_t v) {
    const std::uint32_t old_vertex = canonical_.old_vertex[v];
    const VertexInterpolant* const most = snapshot_.seen_at(old_vertex);
    CompactVertex& vertex = model_.vertices[v];
    if (!most || model_.cameras.empty()) return;
    vertex.seen = true;
    vertex.kernel = kernel_index(model_.kernels, most->views->kernel);
    vertex.sill = most->sill;
    vertex.residual = most->residual;
    vertex.views_folded = most->views_folded;
    std::map<std::uint16_t, CompactView> views;
    for (const PatchVertex& round : snapshot_.shapes().round(old_vertex)) {
      const std::vector<std::uint16_t>& images = grown_[round.patch];
      if (images.empty()) continue;
      const VertexViews& at = *snapshot_.patches()[round.patch]->vertices[round.vertex].views;
      if (at.reflection) {
        vertex.drift = true;
        model_.reflection = at.reflection;
      }
      for (std::size_t j = 0; j < images.size(); ++j) {
        const auto column = static_cast<Eigen::Index>(j);
        CompactView view{.image = images[j], .reliability = at.reliability[column]};
        view.direction = camera_direction(model_, v, view.image);
        view.moved = angle_between(view.direction, at.directions.col(column)) > kMoved;
        if (view.moved) view.direction = at.directions.col(column);
        const auto [known, first] = views.try_emplace(view.image, view);
        if (first) continue;
        view.reliability = std::max(view.reliability, known->second.reliability);
        if (known->second.moved && !view.moved)
          known->second = view;
        else
          known->second.reliability = view.reliability;
      }
    }
    for (const auto& [image, view] : views) vertex.views.push_back(view);
  }

  void fit_patch(std::size_t index) {
    const PatchShape& shape = model_.shapes.patches[index];
    Patch& patch = model_.patches[index];
    const std::vector<std::uint16_t> images = patch_images(model_, shape);
    patch.state.assign(shape.samples, SampleState::kUnseen);
    if (images.empty()) return;
    const auto count = static_cast<Eigen::Index>(images.size());
    Eigen::MatrixXf columns(3 * Eigen::Index{shape.samples}, count);
    for (const std::uint32_t t : shape.triangles) {
      const std::uint32_t first = model_.shapes.first_sample[t];
      const int samples = lattice_samples(model_.maps->resolution(t));
      gather(t, images, columns.middleRows(3 * Eigen::Index{first}, 3 * samples),
             std::span(patch.state).subspan(first, static_cast<std::size_t>(samples)));
    }
    brightest_[index] = columns.maxCoeff();
    patch.mean = columns.rowwise().mean();
    columns.colwise() -= patch.mean;

    Eigen::MatrixXd displayed = Eigen::MatrixXd::Zero(count, count);  // sum over vertices of H H^T
    double views = 0;
    for (const std::uint32_t vertex : shape.vertices) {
      const std::uint32_t source = model_.source[vertex];
      if (source == kNoVertex) continue;
      const std::vector<Eigen::Index> at = places(model_.vertices[source], images);
      const Eigen::MatrixXf shown = smoother(kriging_system(model_, model_.vertices[source], normals_[source]));
      const Eigen::MatrixXd square = (shown * shown.transpose()).template cast<double>();
      for (std::size_t i = 0; i < at.size(); ++i)
        for (std::size_t j = 0; j < at.size(); ++j)
          displayed(at[i], at[j]) += square(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      views += static_cast<double>(at.size());
    }
    factorize(columns, displayed, views, patch);
  }

  /// What the triangle is in each of the images: what its patch has of it, or what is expected from there.
  void gather(std::uint32_t triangle, const std::vector<std::uint16_t>& images, Eigen::Ref<Eigen::MatrixXf> columns,
              std::span<SampleState> state) const {
    const std::uint32_t old = canonical_.old_triangle[triangle];
    const PatchShapes& shapes = filled_->shapes();
    const std::uint32_t p = shapes.patch_of[old];
    const PatchSnapshot& patch = *filled_->patches()[p];
    const int n = model_.maps->resolution(triangle), samples = lattice_samples(n);
    const LatticeResampling finer(filled_->maps().resolution(old), n);
    const auto first = static_cast<int>(shapes.first_sample[old]);
    const std::vector<int> old_sample = rotated_samples(n, canonical_.first_corner[triangle]);
    for (std::size_t s = 0; s < old_sample.size(); ++s) state[s] = patch.state(first + finer.nearest(old_sample[s]));

    const std::vector<std::uint16_t>& known = grown_[p];
    const Eigen::MatrixXf of_known = known.empty() ? Eigen::MatrixXf() : view_coefficients(patch.vertices.front());
    Eigen::MatrixXf coefficients(patch.rank(), columns.cols());
    for (Eigen::Index i = 0; i < coefficients.cols(); ++i) {
      const std::uint16_t image = images[static_cast<std::size_t>(i)];
      const auto view = std::find(known.begin(), known.end(), image);
      coefficients.col(i) =
          view != known.end() ? Eigen::VectorXf(of_known.col(view - known.begin())) : expected(old, patch, image);
    }
    const int own_samples = lattice_samples(filled_->maps().resolution(old));
    const Eigen::MatrixXf values = patch.colours(first, own_samples) * coefficients;
    for (Eigen::Index i = 0; i < columns.cols(); ++i) {
      const Eigen::Matrix3Xf on_n = finer.of(Eigen::Map<const Eigen::Matrix3Xf>(values.col(i).data(), 3, own_samples));
      for (int s = 0; s < samples; ++s)
        columns.col(i).segment<3>(3 * s) = on_n.col(old_sample[static_cast<std::size_t>(s)]);
    }
  }

  /// Coefficients of a patch as a triangle of it is seen from a camera: the mean over its corners.
  Eigen::VectorXf expected(std::uint32_t old_triangle, const PatchSnapshot& patch, std::uint16_t image) const {
    const Eigen::Vector3f eye = camera_centre(model_.cameras[image].camera_from_object).cast<float>();
    const PatchShapes& shapes = filled_->shapes();
    Eigen::VectorXf sum = Eigen::VectorXf::Zero(patch.rank());
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint32_t vertex =
          shapes.corner_column[3 * std::size_t{old_triangle} + c] - shapes.first_column[shapes.patch_of[old_triangle]];
      const Eigen::Vector3f& place = filled_->mesh().corner(old_triangle, static_cast<int>(c));
      sum += patch.vertices[vertex].coefficients((eye - place).normalized());
    }
    return kGreyLevels / 3 * sum;
  }

  /// The leading left singular vectors of columns * displayed^(1/2), as far as they are seen.
  void factorize(const Eigen::MatrixXf& columns, const Eigen::MatrixXd& displayed, double views, Patch& patch) const {
    const Eigen::Index count = columns.cols();
    // Columns may depend on each other; in single precision what is then left of them would be noise.
    const Eigen::MatrixXd exact = columns.cast<double>();
    Eigen::MatrixXd gram = exact.transpose() * exact;
    gram.diagonal().array() += 1e-9 * gram.trace() / static_cast<double>(count) + 1e-12;
    const Eigen::LLT<Eigen::MatrixXd> cholesky(gram);  // columns = Q R, R^T R = gram
    const auto r = cholesky.matrixU();
    const Eigen::MatrixXd seen = r * displayed * r.transpose();
    const SymmetricEigen eigen = symmetric_eigen(seen);
    const double least = least_square_ * views * static_cast<double>(columns.rows());
    Eigen::Index terms = 0;
    while (terms < count && eigen.values[terms] > least) ++terms;
    patch.displayed =
        (eigen.values.head(terms) / (views * static_cast<double>(columns.rows()))).cwiseSqrt().cast<float>();
    Eigen::MatrixXd into = eigen.vectors.leftCols(terms);
    r.solveInPlace(into);
    patch.basis =
        packed_terms((exact * into).cast<float>(), std::sqrt(static_cast<float>(columns.rows())) * patch.displayed);
    patch.coefficients = (eigen.vectors.leftCols(terms).transpose() * Eigen::MatrixXd(r)).cast<float>();
  }

  std::shared_ptr<const SurfaceLightFieldSnapshot> filled_;
  const SurfaceLightFieldSnapshot& snapshot_;
  const CanonicalMesh& canonical_;
  double least_square_;
  std::size_t patch_triangles_;
  CompactModel model_;
  std::vector<std::vector<std::uint16_t>> grown_;  ///< per patch of the snapshot: the images that its views are of
  std::vector<Eigen::Vector3f> normals_;           ///< per vertex
  std::vector<float> brightest_;                   ///< per patch: colour
};

}  // namespace

CompactModel fit_patches(const SurfaceLightFieldSnapshot& snapshot, const CanonicalMesh& canonical, double least_rms,
                         std::size_t patch_triangles) {
  return PatchFit(snapshot, canonical, least_rms, patch_triangles).fit();
}

}  // namespace sheen
