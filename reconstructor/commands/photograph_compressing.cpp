// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/photograph_compressing.h"

#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "reconstructor/capture/photograph_archive.h"
#include "reconstructor/models/model_registry.h"
#include "reconstructor/scene/scene_mesh.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

/// Photographs at some quality, and the PSNR of the model of them; NaN where no view judges it.
struct Coded {
  int quality = 0;
  std::uintmax_t bytes = 0;
  double psnr_db = std::numeric_limits<double>::quiet_NaN();
};

Coded code(const PhotographArchive& archive, const ModelSettings& settings, const fs::path& folder, int quality) {
  Coded coded{.quality = quality, .bytes = archive.write(folder, quality)};
  if (!archive.holds_out_any()) return coded;
  coded.psnr_db = archive.psnr_db(settings, folder);
  std::fprintf(stderr, "quality %d: %.3f MB, %.2f dB\n", quality, static_cast<double>(coded.bytes) / 1e6,
               coded.psnr_db);
  return coded;
}

/// At the worst quality at which the model of them reaches this PSNR, the best where none does. They are left in the
/// folder.
Coded code_to_reach(const PhotographArchive& archive, const ModelSettings& settings, const fs::path& folder,
                    double psnr_db) {
  Coded best;
  int low = 0, high = PhotographCoding::kBest;
  while (low < high) {
    const Coded tried = code(archive, settings, folder, (low + high) / 2);
    if (tried.psnr_db >= psnr_db) {
      best = tried;
      high = tried.quality;
    } else {
      low = tried.quality + 1;
    }
  }
  if (best.bytes == 0) return code(archive, settings, folder, high);
  archive.write(folder, best.quality);
  return best;
}

}  // namespace

nlohmann::json compress_photographs(const std::string& source, const std::string& mesh_file, const std::string& folder,
                                    const SizeArguments& size) {
  const ModelKind& kind = *model_kinds().front();
  const std::optional<CompressionTarget> target = size.target(kind);
  if (!target)
    throw ConfigError("--loss 0dB: photographs of which nothing is lost are the photographs themselves; keep " +
                      source);
  NewFolder out(folder);
  const std::unique_ptr<ModelSettings> settings = kind.default_settings();
  const CaptureSet captures = open_capture_set(source);
  const auto mesh = std::make_shared<const Mesh>(surface_for(*settings, mesh_file, captures.cameras));
  const PhotographArchive archive(captures, mesh, settings->hold_out_every);
  if (archive.size() == 0)
    throw FileError(source, "none of its " + std::to_string(captures.size) +
                                " images shows the mesh; check that both are in the same frame and units");
  if (!archive.holds_out_any() && !target->bytes)
    throw FileError(source, "no view is held out to measure a loss by; name test views, or give --bytes");

  double original_db = std::numeric_limits<double>::quiet_NaN();
  if (archive.holds_out_any()) {
    original_db = archive.psnr_db(*settings);
    std::fprintf(stderr, "the photographs themselves: %.2f dB\n", original_db);
  }
  const Coded coded = target->bytes
                          ? code(archive, *settings, out.unfinished(), archive.quality_within(*target->bytes))
                          : code_to_reach(archive, *settings, out.unfinished(), original_db - target->loss_db);
  out.finish();
  const double loss_db = original_db - coded.psnr_db;
  std::printf("%s: %zu photographs (%zu left out) in %.3f MB, WebP of quality %d\n", folder.c_str(), archive.size(),
              archive.left_out(), static_cast<double>(coded.bytes) / 1e6, coded.quality);
  if (archive.holds_out_any())
    std::printf("a model of them loses %.2f dB of %.2f\n", loss_db, original_db);
  else
    std::printf("what a model of them loses is not known: no view is held out\n");
  std::printf("sheen-reconstructor build %s --mesh %s\n", folder.c_str(), mesh_file.c_str());
  if (target->bytes && coded.bytes > *target->bytes)
    std::fprintf(stderr, "--bytes: even at quality 0 they take more\n");
  if (!target->bytes && loss_db > target->loss_db)
    std::fprintf(stderr, "--loss: even at the best quality more is lost\n");
  nlohmann::json report = {{"bytes", coded.bytes},
                           {"quality", coded.quality},
                           {"photographs", archive.size()},
                           {"left_out", archive.left_out()}};
  if (archive.holds_out_any()) report.update({{"psnr_db", coded.psnr_db}, {"loss_db", loss_db}});
  return {{"photographs", std::move(report)}};
}

}  // namespace sheen
