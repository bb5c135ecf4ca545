// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/gui.h"

#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "common/base/errors.h"
#include "reconstructor/render/gl/gl_objects.h"

namespace sheen {
namespace {

constexpr float kBodySize = 17, kSentenceSize = 22, kLargeSize = 36;  // of type on a screen of ordinary density
constexpr float kFrame_s = 1.0f / 60;                                 // nothing here moves by itself

/// A family of type as Debian's packages install it.
struct Typeface {
  const char *regular, *medium;
};
constexpr Typeface kTypefaces[] = {
    {"/usr/share/fonts/opentype/inter/Inter-Regular.otf", "/usr/share/fonts/opentype/inter/Inter-SemiBold.otf"},
    {"/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf", "/usr/share/fonts/truetype/noto/NotoSans-Medium.ttf"},
    {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"}};

/// Latin with all its accents, Greek and Cyrillic: messages have names of files in them.
constexpr ImWchar kLetters[] = {0x20, 0x24f, 0x370, 0x52f, 0x2010, 0x2027, 0x2190, 0x2193, 0};

ImFont* font(const char* file, float size) {
  ImGuiIO& io = ImGui::GetIO();
  ImFontConfig config;
  config.OversampleH = 2;
  config.OversampleV = 1;
  config.PixelSnapH = false;
  return io.Fonts->AddFontFromFileTTF(file, std::round(size), &config, kLetters);
}

ImFont* built_in_font(float size) {
  ImFontConfig config;
  config.SizePixels = std::round(size);
  return ImGui::GetIO().Fonts->AddFontDefault(&config);
}

void set_style(float scale) {
  ImGuiStyle style;
  style.WindowRounding = 10;
  style.FrameRounding = 6;
  style.PopupRounding = 6;
  style.WindowBorderSize = 0;
  style.PopupBorderSize = 0;
  style.WindowPadding = {14, 11};
  style.FramePadding = {9, 5};
  style.ItemSpacing = {4, 5};
  style.CellPadding = {9, 2};
  style.WindowMinSize = {1, 1};
  style.AntiAliasedLinesUseTex = false;
  style.ScaleAllSizes(scale);
  const ImVec4 ink(0.93f, 0.95f, 0.96f, 1), clear(0, 0, 0, 0);
  style.Colors[ImGuiCol_Text] = ink;
  style.Colors[ImGuiCol_TextDisabled] = {0.63f, 0.69f, 0.74f, 1};
  style.Colors[ImGuiCol_WindowBg] = {0.055f, 0.075f, 0.09f, 0.86f};
  style.Colors[ImGuiCol_PopupBg] = {0.12f, 0.15f, 0.175f, 1};
  style.Colors[ImGuiCol_Button] = clear;
  style.Colors[ImGuiCol_ButtonHovered] = {1, 1, 1, 0.13f};
  style.Colors[ImGuiCol_ButtonActive] = {1, 1, 1, 0.22f};
  style.Colors[ImGuiCol_ScrollbarBg] = clear;
  ImGui::GetStyle() = style;
}

}  // namespace

void Gui::ContextDeleter::operator()(ImGuiContext* context) const {
  ImGui::SetCurrentContext(context);
  ImGui_ImplOpenGL3_Shutdown();
  ImGui::DestroyContext(context);
}

Gui::Gui() {
  IMGUI_CHECKVERSION();
  ImGuiContext* const context = ImGui::CreateContext();
  ImGui::SetCurrentContext(context);
  ImGui::GetIO().IniFilename = nullptr;
  if (!ImGui_ImplOpenGL3_Init("#version 330 core")) throw DeviceError("this graphics driver cannot draw panels");
  context_.reset(context);
}

Gui::~Gui() = default;

void Gui::load_fonts() {
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  body_ = nullptr;
  for (const Typeface& face : kTypefaces) {
    if (!std::filesystem::exists(face.regular) || !std::filesystem::exists(face.medium)) continue;
    body_ = font(face.regular, kBodySize * scale_);
    sentence_ = font(face.medium, kSentenceSize * scale_);
    large_ = font(face.medium, kLargeSize * scale_);
    break;
  }
  if (!body_) {
    body_ = built_in_font(kBodySize * scale_);
    sentence_ = built_in_font(kSentenceSize * scale_);
    large_ = built_in_font(kLargeSize * scale_);
  }
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  if (!ImGui_ImplOpenGL3_CreateFontsTexture()) throw DeviceError("this graphics driver cannot draw letters");
}

void Gui::begin(int width, int height, float scale, const Pointer& pointer) {
  ImGui::SetCurrentContext(context_.get());
  if (scale != scale_) {
    scale_ = scale;
    set_style(scale);
    load_fonts();
  }
  ImGui_ImplOpenGL3_NewFrame();
  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(width), static_cast<float>(height)};
  io.DeltaTime = kFrame_s;
  io.MousePos = {pointer.at.x(), pointer.at.y()};
  io.MouseDown[0] = pointer.pressed;
  io.MouseWheel = pointer.wheel;
  ImGui::NewFrame();
}

void Gui::end() {
  ImGui::SetCurrentContext(context_.get());
  ImGui::Render();
}

void Gui::draw() {
  ImGui::SetCurrentContext(context_.get());
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
  check_gl("drawing the panels");
}

}  // namespace sheen
