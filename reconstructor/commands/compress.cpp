// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/base/command_line.h"
#include "common/base/end_on_stop.h"
#include "common/base/errors.h"
#include "common/base/files.h"
#include "common/base/progress.h"
#include "common/base/report_file.h"
#include "common/base/stop_signal.h"
#include "common/session/session.h"
#include "reconstructor/capture/saved_model.h"
#include "reconstructor/commands/commands.h"
#include "reconstructor/commands/photograph_compressing.h"
#include "reconstructor/commands/size_options.h"

namespace sheen {
namespace {

struct CompressArguments {
  std::string source, mesh, out, json;
  SizeArguments size;
};

nlohmann::json compress_model(const CompressArguments& arguments) {
  if (Session::exists(arguments.source) || std::filesystem::exists(arguments.source + "/transforms.json"))
    throw ConfigError(arguments.source + ": holds photographs, not a model; to make them small, give their --mesh");
  check_writable(arguments.out);
  SavedModel saved = open_model(arguments.source);
  std::optional<CompressionTarget> target = arguments.size.target(*saved.kind);
  if (!target)
    throw ConfigError(arguments.source +
                      ": nothing to compress: --loss is 0dB, or models of this kind have no smaller form");
  target->psnr_db = held_out_psnr_db(saved);
  target->progress = progress_bar("compressing");
  std::unique_ptr<Compression> compression = saved.snapshot->compression(*std::move(target));
  saved.snapshot.reset();
  const CompressedModel small = compression->run();
  compression.reset();  // takes the bar away
  small.snapshot->save(arguments.out, saved.metadata, {});
  const auto bytes = std::filesystem::file_size(arguments.out);
  std::printf("%s: %.3f MB, about %.2f dB lost\n", arguments.out.c_str(), static_cast<double>(bytes) / 1e6,
              small.loss_db);
  return {{"file", {{"bytes", bytes}, {"loss_db", small.loss_db}}}};
}

void compress(const CompressArguments& arguments) {
  install_stop_signals();
  const EndOnStop give_up("sheen-reconstructor: stopped before it was done");
  ReportFile json(arguments.json);
  const nlohmann::json report =
      arguments.mesh.empty() ? compress_model(arguments)
                             : compress_photographs(arguments.source, arguments.mesh, arguments.out, arguments.size);
  json.write(report.dump(2) + "\n");
}

}  // namespace

void add_compress_command(Command& program) {
  auto arguments = std::make_shared<CompressArguments>();
  Command command = program.subcommand("compress",
                                       "Writes a saved model as one small file, or with --mesh the photographs of a "
                                       "session as a small data set (default: --loss 0.1dB).");
  command
      .option("source", arguments->source,
              "folder of a saved model; with --mesh, a session or a data set (transforms.json, COLMAP)")
      .required();
  command.option("--mesh", arguments->mesh,
                 "PLY, OBJ or OFF in the frame of a session or data set, whose photographs are to be made small");
  command.option("--out", arguments->out, "file to write; with --mesh, a new folder").required();
  arguments->size.add_to(command, ", more than 0dB");
  command.option("--json", arguments->json, "report to write; - for standard output");
  command.callback([arguments] { compress(*arguments); });
}

}  // namespace sheen
