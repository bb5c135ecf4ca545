// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/gl/gl_objects.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <vector>

#include "common/base/errors.h"

namespace sheen {
namespace {

const char* name_of_error(GLenum error) {
  switch (error) {
    case GL_INVALID_ENUM:
      return "invalid enum";
    case GL_INVALID_VALUE:
      return "invalid value";
    case GL_INVALID_OPERATION:
      return "invalid operation";
    case GL_INVALID_FRAMEBUFFER_OPERATION:
      return "invalid framebuffer operation";
    case GL_OUT_OF_MEMORY:
      return "out of memory";
    default:
      return "unknown error";
  }
}

GlHandle compile(const std::string& program, GLenum stage, const std::string& source) {
  GlHandle shader(glCreateShader(stage), [](unsigned id) { glDeleteShader(id); });
  const char* text = source.c_str();
  glShaderSource(shader.id(), 1, &text, nullptr);
  glCompileShader(shader.id());
  GLint ok = GL_FALSE;
  glGetShaderiv(shader.id(), GL_COMPILE_STATUS, &ok);
  if (!ok) {
    char log[2048] = {};
    glGetShaderInfoLog(shader.id(), sizeof log - 1, nullptr, log);
    throw DeviceError("OpenGL refuses the " + std::string(stage == GL_VERTEX_SHADER ? "vertex" : "fragment") +
                      " shader of '" + program + "' (update the graphics driver): " + log);
  }
  return shader;
}

GlHandle make_renderbuffer() {
  GLuint id = 0;
  glGenRenderbuffers(1, &id);
  return {id, [](unsigned i) { glDeleteRenderbuffers(1, &i); }};
}

GlHandle make_framebuffer() {
  GLuint id = 0;
  glGenFramebuffers(1, &id);
  return {id, [](unsigned i) { glDeleteFramebuffers(1, &i); }};
}

}  // namespace

GlHandle make_gl_buffer() {
  GLuint id = 0;
  glGenBuffers(1, &id);
  return {id, [](unsigned i) { glDeleteBuffers(1, &i); }};
}

GlHandle make_gl_texture() {
  GLuint id = 0;
  glGenTextures(1, &id);
  return {id, [](unsigned i) { glDeleteTextures(1, &i); }};
}

GlHandle make_gl_vertex_array() {
  GLuint id = 0;
  glGenVertexArrays(1, &id);
  return {id, [](unsigned i) { glDeleteVertexArrays(1, &i); }};
}

void check_gl(const std::string& operation) {
  if (const GLenum error = glGetError(); error != GL_NO_ERROR)
    throw DeviceError("OpenGL error in " + operation + ": " + name_of_error(error));
}

GlProgram::GlProgram(const std::string& name, const std::string& vertex_source, const std::string& fragment_source)
    : program_(glCreateProgram(), [](unsigned id) { glDeleteProgram(id); }) {
  const GlHandle vertex = compile(name, GL_VERTEX_SHADER, vertex_source);
  const GlHandle fragment = compile(name, GL_FRAGMENT_SHADER, fragment_source);
  glAttachShader(program_.id(), vertex.id());
  glAttachShader(program_.id(), fragment.id());
  glLinkProgram(program_.id());
  GLint ok = GL_FALSE;
  glGetProgramiv(program_.id(), GL_LINK_STATUS, &ok);
  if (!ok) {
    char log[2048] = {};
    glGetProgramInfoLog(program_.id(), sizeof log - 1, nullptr, log);
    throw DeviceError("OpenGL cannot link '" + name + "' (update the graphics driver): " + log);
  }
}

void GlProgram::use() const {
  glUseProgram(program_.id());
}

int GlProgram::uniform(const char* name) const {
  return glGetUniformLocation(program_.id(), name);
}

BufferTexture::BufferTexture(unsigned internal_format, std::size_t texel_bytes)
    : internal_format_(internal_format),
      texel_bytes_(texel_bytes),
      buffer_(make_gl_buffer()),
      texture_(make_gl_texture()) {}

std::size_t BufferTexture::max_texels() {
  GLint texels = 0;
  glGetIntegerv(GL_MAX_TEXTURE_BUFFER_SIZE, &texels);
  return static_cast<std::size_t>(texels);
}

void BufferTexture::attach() const {
  glBindTexture(GL_TEXTURE_BUFFER, texture_.id());
  glTexBuffer(GL_TEXTURE_BUFFER, internal_format_, buffer_.id());
}

bool BufferTexture::grow(std::size_t texels) {
  if (texels <= texels_) return true;
  check_gl("the work before a buffer grows");
  GlHandle larger = make_gl_buffer();
  glBindBuffer(GL_COPY_WRITE_BUFFER, larger.id());
  glBufferData(GL_COPY_WRITE_BUFFER, static_cast<GLsizeiptr>(texels * texel_bytes_), nullptr, GL_DYNAMIC_DRAW);
  if (glGetError() != GL_NO_ERROR) return false;
  if (texels_ > 0) {
    glBindBuffer(GL_COPY_READ_BUFFER, buffer_.id());
    glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER, 0, 0,
                        static_cast<GLsizeiptr>(texels_ * texel_bytes_));
  }
  buffer_ = std::move(larger);
  texels_ = texels;
  attach();
  return true;
}

void BufferTexture::write(std::size_t first_texel, std::size_t count, const void* data) {
  glBindBuffer(GL_TEXTURE_BUFFER, buffer_.id());
  glBufferSubData(GL_TEXTURE_BUFFER, static_cast<GLintptr>(first_texel * texel_bytes_),
                  static_cast<GLsizeiptr>(count * texel_bytes_), data);
}

void BufferTexture::assign(std::size_t count, const void* data) {
  if (count > max_texels())
    throw DeviceError("the mesh is too large for this graphics driver: a table of " + std::to_string(count) +
                      " entries, the driver allows " + std::to_string(max_texels()) +
                      "; simplify the mesh, or use `render`, which needs no graphics card");
  glBindBuffer(GL_TEXTURE_BUFFER, buffer_.id());
  glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(count * texel_bytes_), data, GL_STREAM_DRAW);
  if (count != texels_) attach();
  texels_ = count;
}

void BufferTexture::bind(int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_BUFFER, texture_.id());
}

RenderTarget::RenderTarget(int width, int height, int samples)
    : width_(width),
      height_(height),
      color_(make_renderbuffer()),
      depth_(make_renderbuffer()),
      framebuffer_(make_framebuffer()),
      picture_color_(make_renderbuffer()),
      picture_(make_framebuffer()) {
  GLint most = 0, largest = 0;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  glGetIntegerv(GL_MAX_RENDERBUFFER_SIZE, &largest);
  if (width < 1 || height < 1 || width > largest || height > largest)
    throw DeviceError("cannot draw " + std::to_string(width) + "x" + std::to_string(height) +
                      " pixels: each side must be 1.." + std::to_string(largest));
  samples = samples > 1 ? std::min(samples, most) : 0;

  glBindRenderbuffer(GL_RENDERBUFFER, color_.id());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA8, width, height);
  glBindRenderbuffer(GL_RENDERBUFFER, depth_.id());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT24, width, height);
  glBindRenderbuffer(GL_RENDERBUFFER, picture_color_.id());
  glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);

  glBindFramebuffer(GL_FRAMEBUFFER, picture_.id());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, picture_color_.id());
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_.id());
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
    throw DeviceError("this graphics driver cannot draw off the screen at " + std::to_string(width) + "x" +
                      std::to_string(height) + "; try a smaller window");
  check_gl("making a picture to draw into");
}

void RenderTarget::clear(const Eigen::Vector3f& color) const {
  draw_on();
  glClearColor(color.x(), color.y(), color.z(), 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

void RenderTarget::draw_on() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
}

void RenderTarget::resolve() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, picture_.id());
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.id());
}

void RenderTarget::draw_over() const {
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.id());
}

void RenderTarget::clear_picture(const Eigen::Vector3f& color) const {
  draw_over();
  glClearColor(color.x(), color.y(), color.z(), 1);
  glClear(GL_COLOR_BUFFER_BIT);
}

void RenderTarget::enlarge(const RenderTarget& other, const Panel& from, const Panel& to) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, other.picture_.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, picture_.id());
  const int from_bottom = other.height_ - from.y - from.height, to_bottom = height_ - to.y - to.height;
  glBlitFramebuffer(from.x, from_bottom, from.x + from.width, from_bottom + from.height, to.x, to_bottom,
                    to.x + to.width, to_bottom + to.height, GL_COLOR_BUFFER_BIT, GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, picture_.id());
}

void RenderTarget::show(int window_width, int window_height) const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, picture_.id());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, window_width, window_height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

ImageU8 RenderTarget::read() const {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, picture_.id());
  ImageU8 bottom_up(width_, height_, 3), picture(width_, height_, 3);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, bottom_up.data());
  for (int y = 0; y < height_; ++y)
    std::copy_n(bottom_up.row(height_ - 1 - y), std::size_t(width_) * 3, picture.row(y));
  return picture;
}

ScissorScope::ScissorScope(const Panel& part, int target_height) {
  glScissor(part.x, target_height - part.y - part.height, part.width, part.height);
  glEnable(GL_SCISSOR_TEST);
}

ScissorScope::~ScissorScope() {
  glDisable(GL_SCISSOR_TEST);
}

}  // namespace sheen
