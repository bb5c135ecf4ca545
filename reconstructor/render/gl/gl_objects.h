// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <utility>

#include "common/image/image.h"
#include "reconstructor/render/gl/panel.h"

namespace sheen {

/// Owner of one OpenGL object; move-only. Made and destroyed with the context current.
class GlHandle {
 public:
  using Deleter = void (*)(unsigned id);

  GlHandle() = default;
  GlHandle(unsigned id, Deleter deleter) : id_(id), deleter_(deleter) {}
  GlHandle(GlHandle&& other) noexcept : id_(std::exchange(other.id_, 0)), deleter_(other.deleter_) {}
  GlHandle& operator=(GlHandle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(deleter_, other.deleter_);
    return *this;
  }
  ~GlHandle() {
    if (id_) deleter_(id_);
  }
  unsigned id() const { return id_; }

 private:
  unsigned id_ = 0;
  Deleter deleter_ = nullptr;
};

GlHandle make_gl_buffer();
GlHandle make_gl_texture();
GlHandle make_gl_vertex_array();

/// Throws DeviceError naming the operation when OpenGL has reported an error since the last call.
void check_gl(const std::string& operation);

/// Vertex and fragment shader, linked.
class GlProgram {
 public:
  /// Throws DeviceError with the driver's log.
  GlProgram(const std::string& name, const std::string& vertex_source, const std::string& fragment_source);
  void use() const;
  int uniform(const char* name) const;  ///< -1 where the driver has optimised it away, which OpenGL ignores

 private:
  GlHandle program_;
};

/// A buffer that shaders read with `texelFetch`. Texels live until they are overwritten; growing keeps them.
class BufferTexture {
 public:
  /// `internal_format` as of glTexBuffer; `texel_bytes` its size.
  BufferTexture(unsigned internal_format, std::size_t texel_bytes);

  std::size_t texels() const { return texels_; }
  /// Keeps the contents. False, and nothing is changed, when the GPU has no memory left for it.
  bool grow(std::size_t texels);
  void write(std::size_t first_texel, std::size_t count, const void* data);
  /// Replaces everything; throws DeviceError beyond what the driver allows.
  void assign(std::size_t count, const void* data);
  void bind(int unit) const;

  static std::size_t max_texels();  ///< GL_MAX_TEXTURE_BUFFER_SIZE

 private:
  void attach() const;

  unsigned internal_format_;
  std::size_t texel_bytes_;
  std::size_t texels_ = 0;
  GlHandle buffer_, texture_;
};

/// Limits drawing and clearing to a part of a target while it lives.
class ScissorScope {
 public:
  ScissorScope(const Panel& part, int target_height);
  ~ScissorScope();
  ScissorScope(const ScissorScope&) = delete;
  ScissorScope& operator=(const ScissorScope&) = delete;
};

/// What is drawn into before it is shown: 8-bit RGB and depth with `samples` a pixel, and the picture that their means
/// make, which can be drawn over.
class RenderTarget {
 public:
  /// `samples` is cut to what the driver has. Throws DeviceError.
  RenderTarget(int width, int height, int samples);

  int width() const { return width_; }
  int height() const { return height_; }
  void clear(const Eigen::Vector3f& color) const;  ///< the samples; drawing goes there from now on
  void draw_on() const;                            ///< drawing goes to the samples again, which stay as they are
  void resolve() const;                            ///< samples -> picture; drawing goes to the picture from now on

  void draw_over() const;                                  ///< drawing goes to the picture from now on
  void clear_picture(const Eigen::Vector3f& color) const;  ///< drawing goes to the picture from now on
  /// A part of another target's picture over a part of this one's, smoothly enlarged. Drawing goes to the picture from
  /// now on.
  void enlarge(const RenderTarget& other, const Panel& from, const Panel& to) const;

  void show(int window_width,
            int window_height) const;  ///< the picture, to the window's back buffer, where drawing goes then
  ImageU8 read() const;                ///< the picture: RGB, top row first

 private:
  int width_, height_;
  GlHandle color_, depth_, framebuffer_;
  GlHandle picture_color_, picture_;
};

}  // namespace sheen
