// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/python/work.h"

#include <array>
#include <nlohmann/json.hpp>

#include "common/base/errors.h"
#include "reconstructor/commands/export_page.h"
#include "reconstructor/commands/exports.h"
#include "reconstructor/evaluation/evaluation_report.h"
#include "reconstructor/python/interruptible.h"

namespace sheen {
namespace {

using Json = nlohmann::json;
using Path = std::filesystem::path;

std::string name_of(const OpenModel& model) {
  return model.path().string();
}

template <Path SurfaceFiles::*kFile>
Json surface(const OpenModel& model, const Path& out) {
  SurfaceFiles files;
  files.*kFile = out;
  return export_surface(model.snapshot(), name_of(model), files);
}

Json relight(const OpenModel& model, const Path& out) {
  return {{"relight", export_relight(model.snapshot(), name_of(model), out)}};
}

Json splats(const OpenModel& model, const Path& out) {
  return {{"splats", export_splats(model.snapshot(), name_of(model), out)}};
}

template <auto kWrite>
Json page(const OpenModel& model, const Path& out) {
  kWrite(model.path(), out, page_text(model.path()));
  return Json::object();
}

/// What a model is written as, and the ending that says so; null: none does.
struct Form {
  const char *name, *ending;
  Json (*write)(const OpenModel&, const Path&);
};
constexpr std::array<Form, 8> kForms{{{"gltf", ".glb", surface<&SurfaceFiles::gltf>},
                                      {"ply", ".ply", surface<&SurfaceFiles::ply>},
                                      {"obj", ".obj", surface<&SurfaceFiles::obj>},
                                      {"usdz", ".usdz", surface<&SurfaceFiles::usdz>},
                                      {"splats", nullptr, splats},
                                      {"relight", ".ptm", relight},
                                      {"single", ".html", page<write_single_page>},
                                      {"page", "", page<write_page>}}};

const Form& form_of(const Path& out, const std::string& name) {
  for (const Form& form : kForms)
    if (name.empty() ? form.ending && out.extension() == form.ending : name == form.name) return form;
  std::string all;
  for (const Form& form : kForms) all += std::string(all.empty() ? "" : ", ") + form.name;
  throw ConfigError((name.empty() ? out.string() + ": its ending says no form" : "form: is not \"" + name + "\"") +
                    "; there are " + all);
}

}  // namespace

std::string evaluated(const OpenModel& model, EvaluateRequest request) {
  request.told = false;
  std::string report;
  interruptible([&] { report = to_text(evaluate(model.saved(), model.path().string(), request)); });
  return report;
}

std::string exported(const OpenModel& model, const Path& out, const std::string& form) {
  const Form& asked = form_of(out, form);
  Json report;
  interruptible([&] { report = asked.write(model, out); });
  return to_text(report);
}

std::string built(const BuildRequest& request) {
  std::string report;
  interruptible([&] { build(request, [&](const nlohmann::json& made) { report = to_text(made); }); });
  return report;
}

}  // namespace sheen
