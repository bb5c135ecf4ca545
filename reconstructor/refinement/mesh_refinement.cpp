// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/refinement/mesh_refinement.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/errors.h"
#include "common/base/order_statistics.h"
#include "common/geometry/ray_scene.h"
#include "common/registration/silhouette.h"
#include "reconstructor/refinement/displacement_field.h"
#include "reconstructor/refinement/kept_outlines.h"
#include "reconstructor/refinement/normal_sweep.h"
#include "reconstructor/refinement/outline_edges.h"
#include "reconstructor/refinement/silhouette_rims.h"
#include "reconstructor/refinement/sweep_minimum.h"
#include "reconstructor/refinement/vertex_patches.h"

namespace sheen {
namespace {

/// From coarse to fine: pixels between the points of a patch, of which a sweep reaches four to either side, and how
/// often the surface that patches lie on is smoothed. A rough mesh has shape by the time that its edges are believed.
/// `insignificant`: standard deviations up to which a displacement is chance; one more, and it is made in full. The
/// passes before the last look for the surface; the last judges.
struct PassPlan {
  double spacing_px;
  int smoothing;
  double insignificant;
};
constexpr std::array<PassPlan, 7> kPasses{
    {{4, 2, 1}, {4, 2, 1}, {2, 1, 1}, {2, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 0, 2}}};
/// Patch spacings by which the surface may be off where a patch is seen; more where patches are smoother than it.
constexpr double kClearance = 1, kClearanceOfSmoothing = 0.5;
/// Energy per squared spacing that draws the choice among several minima towards no move, or to what neighbours say.
constexpr double kPull = 0.004, kPullOfNeighbours = 0.016;
constexpr int kNeighbourRounds = 2;
constexpr float kLeastAgreement = 0.5f;  // mean correlation of the images about a patch; else they show something else
/// Standard deviations of the displacement's slope along the surface, of which one is chosen. More would fold it.
constexpr std::array kSlopes{0.3, 0.1, 0.03};
constexpr double kMaskSigma_px = 1, kSilhouetteSigma_px = 1.5;  // outline of a mask, of the mesh as it was given
/// Standard deviation of what all images get wrong alike (highlights, what filters do to edges), patch spacings: the
/// halves cannot show it.
constexpr double kCommonError = 0.2;
/// How far round a vertex displacements speak for its own, and the standard deviations, root of the mean square, up to
/// which they are chance: so many together seldom are.
constexpr int kSignificanceSmoothing = 40;
constexpr double kInsignificantRound = 1.5;
constexpr double kMedianOfChiSquared = 0.4549;  // of one degree of freedom
/// How far round a vertex the difference of the halves is averaged, with how much of what it is everywhere, and how
/// much a single vertex counts at most.
constexpr int kOverconfidenceSmoothing = 8;
constexpr double kOverconfidencePrior = 0.05, kMostSquared = 25;

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

std::vector<float> mean_edge_lengths(const Mesh& mesh, const MeshEdges& edges) {
  std::vector<float> lengths(mesh.vertices.size(), 0);
  for (std::size_t v = 0; v < lengths.size(); ++v)
    for (const std::uint32_t n : edges.around(v))
      lengths[v] += (mesh.vertices[n] - mesh.vertices[v]).norm() / static_cast<float>(edges.around(v).size());
  return lengths;
}

/// What one pass asks, the same for all images.
struct PassShape {
  std::vector<float> spacing;             ///< of the patches, metres
  std::vector<float> overlap;             ///< how many vertices see a place of the surface in their patches
  std::vector<DisplacementPrior> priors;  ///< of which one is chosen
};

PassShape shape_of_pass(double spacing_px, const std::vector<float>& footprints, const std::vector<float>& lengths) {
  PassShape shape;
  for (std::size_t v = 0; v < footprints.size(); ++v) {
    // A patch that is finer than the mesh shows what the mesh cannot follow.
    shape.spacing.push_back(static_cast<float>(spacing_px) * std::max(footprints[v], lengths[v] / (kPatchSide - 1)));
    const float vertices_across = kPatchSide * shape.spacing[v] / std::max(lengths[v], 1e-12f);
    shape.overlap.push_back(std::max(1.0f, vertices_across * vertices_across));
  }
  const double ridge = 1 / std::pow(kSweepReach * mean(shape.spacing), 2);
  for (const double slope : kSlopes) shape.priors.push_back({1 / std::pow(slope * mean(lengths), 2), ridge});
  return shape;
}

/// Displacements from where the mesh was given; `moved`: what the passes before made of them.
Observations observe(const NormalSweep& sweep, NormalSweep::Part part, const PassShape& shape,
                     const Eigen::VectorXd& moved, const Eigen::VectorXd* guide) {
  Observations observed(static_cast<Eigen::Index>(shape.spacing.size()));
  tbb::parallel_for(Eigen::Index{0}, observed.value.size(), [&](Eigen::Index v) {
    const double metres = shape.spacing[v];
    const auto minimum =
        sweep_minimum(sweep.energy(v, part), sweep.images(v, part), guide ? ((*guide)[v] - moved[v]) / metres : 0,
                      guide ? kPullOfNeighbours : kPull);
    if (!minimum) return;
    const int nearest = kSweepReach + static_cast<int>(std::lround(minimum->place));
    if (sweep.agreement(v, nearest) < kLeastAgreement) return;
    observed.add(v, moved[v] + minimum->place * metres, minimum->information / (metres * metres));
  });
  return observed;
}

/// By how much the halves differ more than their information says: what it is to be divided by, per vertex. It is the
/// mean over the vertices round it: a glossy part is less certain than the rest.
Eigen::VectorXd overconfidence(const MeshEdges& edges, const Observations& first, const Observations& second) {
  const auto squared = [&](Eigen::Index v) {
    return std::pow(first.value[v] - second.value[v], 2) / (1 / first.information[v] + 1 / second.information[v]);
  };
  std::vector<double> all;
  for (Eigen::Index v = 0; v < first.value.size(); ++v)
    if (first.information[v] > 0 && second.information[v] > 0) all.push_back(squared(v));
  if (all.empty()) return Eigen::VectorXd::Ones(first.value.size());
  const double everywhere = std::max(median(all) / kMedianOfChiSquared, 1e-12);
  // Sum, number and nothing.
  std::vector<Eigen::Vector3f> sums(first.value.size(), Eigen::Vector3f::Zero());
  for (Eigen::Index v = 0; v < first.value.size(); ++v)
    if (first.information[v] > 0 && second.information[v] > 0)
      sums[v] = {static_cast<float>(std::min(squared(v) / everywhere, kMostSquared)), 1, 0};
  sums = smoothed(std::move(sums), edges, kOverconfidenceSmoothing);
  Eigen::VectorXd factor(first.value.size());
  for (Eigen::Index v = 0; v < factor.size(); ++v)
    factor[v] = everywhere * (sums[v][0] + kOverconfidencePrior) / (sums[v][1] + kOverconfidencePrior);
  return factor;
}

/// What outlines say.
struct Rims {
  Observations masked;  ///< against masks
  Observations edges;   ///< against edges of images without one
  Observations held;    ///< against the mesh as it was given, which observes nothing
};

/// The displacement that images and rims make most probable, its variance, and what was observed.
struct Estimate {
  Observations observed;  ///< by images and masks
  DisplacementField field;
};

Estimate estimate(const MeshEdges& edges, const NormalSweep& sweep, const Rims& rims, const PassShape& shape,
                  const Eigen::VectorXd& moved) {
  Observations first = observe(sweep, NormalSweep::kFirst, shape, moved, nullptr);
  Observations second = observe(sweep, NormalSweep::kSecond, shape, moved, nullptr);
  const Eigen::VectorXd factor = overconfidence(edges, first, second);
  const auto weigh = [&](Observations& observed) {
    for (Eigen::Index v = 0; v < observed.information.size(); ++v)
      observed.information[v] /= factor[v] * shape.overlap[v];
  };
  weigh(first);
  weigh(second);
  const DisplacementPrior prior = cross_validated(edges, first, second, shape.priors);

  const auto from_given = [&](Observations rim) {
    rim.value += moved;
    return rim;
  };

  Estimate result;
  std::array sources{Observations(), from_given(rims.masked), from_given(rims.edges), from_given(rims.held)};
  for (int round = 0; round <= kNeighbourRounds; ++round) {
    sources[0] = observe(sweep, NormalSweep::kBoth, shape, moved, round > 0 ? &result.field.value : nullptr);
    weigh(sources[0]);
    result.field = most_probable_field(edges, sources, prior, round == kNeighbourRounds);
  }
  result.observed = sources[0];
  result.observed.add(sources[1]);
  result.observed.add(sources[2]);
  for (Eigen::Index v = 0; v < result.field.variance.size(); ++v)
    result.field.variance[v] += std::pow(kCommonError * shape.spacing[v], 2);
  return result;
}

/// Where vertices go, from where the mesh was given: a vertex stays there while the displacements round it are within
/// `insignificant` standard deviations, and goes all the way from one more on. A surface that is wrong is wrong over
/// some width: what is known well of a part speaks for what is known less well beside it.
Eigen::VectorXd significant(const MeshEdges& edges, const DisplacementField& field, double insignificant) {
  // Of the displacements, in standard deviations.
  std::vector<Eigen::Vector3f> squares(static_cast<std::size_t>(field.value.size()));
  for (Eigen::Index v = 0; v < field.value.size(); ++v)
    squares[v] = {static_cast<float>(field.value[v] * field.value[v] / field.variance[v]), 0, 0};
  const std::vector<Eigen::Vector3f> round = smoothed(squares, edges, kSignificanceSmoothing);
  Eigen::VectorXd kept = field.value;
  for (Eigen::Index v = 0; v < kept.size(); ++v) {
    double beside = field.value[v] * field.value[v];
    for (const std::uint32_t n : edges.around(v)) beside += field.value[n] * field.value[n];
    beside /= static_cast<double>(edges.around(v).size() + 1) * field.variance[v];
    const double beyond = std::max(std::sqrt(beside) - insignificant,
                                   std::sqrt(round[v][0]) - std::min(insignificant, kInsignificantRound));
    kept[v] *= std::clamp(beyond, 0.0, 1.0);
  }
  return kept;
}

/// What no image sees is continued from what they see, and may be off by as much as that was.
void continue_unseen(const MeshEdges& edges, const Observations& observed, Eigen::VectorXd& moves,
                     Eigen::VectorXd& variance) {
  continue_smoothly(edges, observed, moves);
  const auto seen = (observed.information.array() > 0).cast<double>();
  const double as_seen = (moves.array().square() * seen).sum() / std::max(seen.sum(), 1.0);
  variance.array() += as_seen * (1 - seen);
}

/// What the images show at the place of the sweep that is nearest to where each vertex went.
std::vector<ExpectedPatch> expected_after(const NormalSweep& sweep, const PassShape& shape,
                                          const Eigen::VectorXd& moves) {
  std::vector<ExpectedPatch> expected;
  for (Eigen::Index v = 0; v < moves.size(); ++v) {
    const double place = std::clamp(moves[v] / shape.spacing[v], -double(kSweepReach), double(kSweepReach));
    expected.push_back(sweep.expected(v, kSweepReach + static_cast<int>(std::lround(place))));
  }
  return expected;
}

RefinementPass apply(const Estimate& found, const NormalSweep& sweep, const VertexPatches& patches,
                     const Eigen::VectorXd& moves, double spacing_px, RefinedMesh& refined) {
  RefinementPass pass{.spacing_px = spacing_px};
  for (Eigen::Index v = 0; v < moves.size(); ++v) {
    const bool observed = found.observed.information[v] > 0;
    pass.observed += observed;
    pass.moved += moves[v] != 0;
    pass.rms_move += moves[v] * moves[v];
    if (observed) pass.agreement += sweep.agreement(v, kSweepReach);
    refined.mesh.vertices[v] += static_cast<float>(moves[v]) * patches.normals[v];
    refined.moved[v] += static_cast<float>(moves[v]);
    refined.uncertainty[v] = static_cast<float>(std::sqrt(found.field.variance[v]));
    refined.observed[v] = observed;
  }
  pass.rms_move = std::sqrt(pass.rms_move / static_cast<double>(moves.size()));
  pass.agreement /= static_cast<double>(std::max<std::size_t>(pass.observed, 1));
  return pass;
}

}  // namespace

RefinedMesh refine_mesh(const Mesh& mesh, const RefinementImages& images, UnmaskedOutlines outlines,
                        const StepsDone& progress) {
  if (images.cameras.size() < 2) throw Error("refining a mesh needs two images or more that are not held out");
  RefinedMesh refined{.mesh = mesh,
                      .moved = std::vector<float>(mesh.vertices.size(), 0),
                      .uncertainty = std::vector<float>(mesh.vertices.size(), 0),
                      .observed = std::vector<bool>(mesh.vertices.size(), false)};
  const MeshEdges edges(mesh);
  const std::vector<float> footprints = pixel_footprints(mesh, images.cameras);
  const std::vector<float> lengths = mean_edge_lengths(mesh, edges);
  const RayScene given(mesh);
  SilhouetteCaster caster;
  std::size_t done = 0;
  std::vector<ExpectedPatch> expected;  // of the pass before, where its patches are as large
  for (std::size_t p = 0; p < kPasses.size(); ++p) {
    const double spacing_px = kPasses[p].spacing_px;
    const PassShape shape = shape_of_pass(spacing_px, footprints, lengths);
    const VertexPatches patches(refined.mesh, edges, shape.spacing, kPasses[p].smoothing);
    const double clearance = kClearance + kClearanceOfSmoothing * kPasses[p].smoothing;
    const RayScene scene(refined.mesh);
    const bool last = p + 1 == kPasses.size();
    // While the surface is off, views from different sides disagree for that reason alone.
    const std::vector<ViewSplit> splits =
        last ? split_views(refined.mesh, patches.normals, images.cameras) : std::vector<ViewSplit>{};
    NormalSweep sweep(refined.mesh, patches, splits, clearance, expected);
    const auto vertices = static_cast<Eigen::Index>(mesh.vertices.size());
    Rims rims{Observations(vertices), Observations(vertices), Observations(vertices)};
    OutlineEdges outline_edges(refined.mesh, patches.normals, shape.spacing);
    for (std::size_t i = 0; i < images.cameras.size(); ++i) {
      const Capture capture = images.read(i);
      const PosedCamera& view = images.cameras[i];
      const GreyPyramid pyramid(capture);
      sweep.add(pyramid, view, scene);
      const bool masked = !capture.mask.empty();
      if (!masked && outlines == UnmaskedOutlines::kFromEdges) {
        outline_edges.add(pyramid, view, scene);
      } else {
        const ImageF from_outline = distance_from_outline(masked ? capture.mask : caster.cast(view, mesh, given));
        observe_rims(refined.mesh, patches.normals, scene, view, from_outline,
                     masked ? kMaskSigma_px : kSilhouetteSigma_px, kSweepReach * spacing_px,
                     masked ? rims.masked : rims.held);
      }
      if (progress) progress(++done, images.cameras.size() * kPasses.size());
    }
    rims.edges = outline_edges.observe(edges);
    const Eigen::VectorXd moved = Eigen::Map<const Eigen::VectorXf>(refined.moved.data(), vertices).cast<double>();
    Estimate found = estimate(edges, sweep, rims, shape, moved);
    Eigen::VectorXd kept = significant(edges, found.field, kPasses[p].insignificant);
    // In an earlier pass it would hide what is seen.
    if (last) continue_unseen(edges, found.observed, kept, found.field.variance);
    const Eigen::VectorXd moves = kept - moved;
    refined.passes.push_back(apply(found, sweep, patches, moves, spacing_px, refined));
    const bool same_next = !last && kPasses[p + 1].spacing_px == spacing_px;
    expected = same_next ? expected_after(sweep, shape, moves) : std::vector<ExpectedPatch>{};
  }
  keep_outlines_covered(mesh, images, footprints, refined);
  return refined;
}

}  // namespace sheen
