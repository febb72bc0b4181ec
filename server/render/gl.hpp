#pragma once
// Owners of GL objects. Every owner must be made and destroyed
// while its GlContext is current.
//
//     GlProgram program("lines", vertex_source, fragment_source);
//     GlBuffer positions;
//     positions.upload(std::as_bytes(std::span(vertices)));

#include "server/render/gl_functions.hpp"

#include <Eigen/Core>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

namespace tetfront {

/// A linked program. Sources start with "#version 330 core".
class GlProgram {
 public:
    /// Throws LogicError with the compiler's log.
    GlProgram(const char* name, std::string_view vertex, std::string_view fragment);
    ~GlProgram() { glDeleteProgram(id_); }
    GlProgram(const GlProgram&) = delete;
    GlProgram& operator=(const GlProgram&) = delete;

    void use() const { glUseProgram(id_); }
    // Uniforms of the program in use. Setting one that the program does not have is a bug: LogicError.
    void set(const char* uniform, int value) const { glUniform1i(location(uniform), value); }
    void set(const char* uniform, float value) const { glUniform1f(location(uniform), value); }
    void set(const char* uniform, const Eigen::Vector2i& v) const { glUniform2i(location(uniform), v[0], v[1]); }
    void set(const char* uniform, const Eigen::Vector2f& v) const { glUniform2f(location(uniform), v[0], v[1]); }
    void set(const char* uniform, const Eigen::Vector3f& v) const { glUniform3f(location(uniform), v[0], v[1], v[2]); }
    void set(const char* uniform, const Eigen::Vector4f& v) const {
        glUniform4f(location(uniform), v[0], v[1], v[2], v[3]);
    }
    void set(const char* uniform, const Eigen::Matrix4f& m) const {
        glUniformMatrix4fv(location(uniform), 1, GL_FALSE, m.data());
    }
    /// Binds the texture to the unit and points the sampler at it.
    void set_texture(const char* sampler, int unit, GLenum target, GLuint texture) const;

 private:
    [[nodiscard]] GLint location(const char* uniform) const;

    const char* name_;
    GLuint id_ = 0;
    mutable std::unordered_map<std::string_view, GLint> locations_;
};

class GlBuffer {
 public:
    GlBuffer() { glGenBuffers(1, &id_); }
    ~GlBuffer() { glDeleteBuffers(1, &id_); }
    GlBuffer(const GlBuffer&) = delete;
    GlBuffer& operator=(const GlBuffer&) = delete;

    [[nodiscard]] GLuint id() const { return id_; }
    /// Replaces the content.
    void upload(std::span<const std::byte> bytes, GLenum target = GL_ARRAY_BUFFER);

 private:
    GLuint id_ = 0;
    std::size_t capacity_ = 0;
};

class GlVertexArray {
 public:
    GlVertexArray() { glGenVertexArrays(1, &id_); }
    ~GlVertexArray() { glDeleteVertexArrays(1, &id_); }
    GlVertexArray(const GlVertexArray&) = delete;
    GlVertexArray& operator=(const GlVertexArray&) = delete;

    void bind() const { glBindVertexArray(id_); }
    /// `components` floats (or normalised bytes) of the buffer as attribute `index`. divisor 1: one per instance.
    void attribute(GLuint index, const GlBuffer& buffer, int components, GLenum type = GL_FLOAT, int stride = 0,
                   std::size_t offset = 0, GLuint divisor = 0) const;

 private:
    GLuint id_ = 0;
};

/// A 2D texture that can be drawn into. Allocated again only when size or format change.
class GlTexture {
 public:
    GlTexture() { glGenTextures(1, &id_); }
    ~GlTexture() { glDeleteTextures(1, &id_); }
    GlTexture(const GlTexture&) = delete;
    GlTexture& operator=(const GlTexture&) = delete;

    [[nodiscard]] GLuint id() const { return id_; }
    [[nodiscard]] int width() const { return width_; }
    [[nodiscard]] int height() const { return height_; }
    /// format e.g. GL_RGBA8, GL_R8, GL_RGBA16F, GL_DEPTH_COMPONENT32F; filter GL_NEAREST or GL_LINEAR. Clamps to edge.
    void allocate(int width, int height, GLenum format, GLint filter);

 private:
    GLuint id_ = 0;
    int width_ = 0, height_ = 0;
    GLenum format_ = 0;
};

class GlFramebuffer {
 public:
    GlFramebuffer() { glGenFramebuffers(1, &id_); }
    ~GlFramebuffer() { glDeleteFramebuffers(1, &id_); }
    GlFramebuffer(const GlFramebuffer&) = delete;
    GlFramebuffer& operator=(const GlFramebuffer&) = delete;

    /// Attaches (either may be null), binds, and sets the viewport to the textures' size.
    void bind(const GlTexture* colour, const GlTexture* depth) const;

 private:
    GLuint id_ = 0;
};

}  // namespace tetfront
