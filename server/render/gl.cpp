#include "server/render/gl.hpp"

#include "engine/base/error.hpp"

namespace tetfront {

namespace {

GLuint compile(const char* name, GLenum kind, std::string_view source) {
    const GLuint shader = glCreateShader(kind);
    const char* text = source.data();
    const auto length = static_cast<GLint>(source.size());
    glShaderSource(shader, 1, &text, &length);
    glCompileShader(shader);
    GLint good = 0;
    glGetShaderiv(shader, GL_COMPILE_STATUS, &good);
    if (!good) {
        std::string log(4096, '\0');
        GLsizei written = 0;
        glGetShaderInfoLog(shader, static_cast<GLsizei>(log.size()), &written, log.data());
        log.resize(static_cast<std::size_t>(written));
        throw LogicError(std::string("shader ") + name + ": " + log);
    }
    return shader;
}

}  // namespace

GlProgram::GlProgram(const char* name, std::string_view vertex, std::string_view fragment)
    : name_(name), id_(glCreateProgram()) {
    const GLuint shaders[] = {compile(name, GL_VERTEX_SHADER, vertex), compile(name, GL_FRAGMENT_SHADER, fragment)};
    for (const GLuint shader : shaders) glAttachShader(id_, shader);
    glLinkProgram(id_);
    for (const GLuint shader : shaders) glDeleteShader(shader);
    GLint good = 0;
    glGetProgramiv(id_, GL_LINK_STATUS, &good);
    ENSURE(good, "program ", name, " does not link");
}

GLint GlProgram::location(const char* uniform) const {
    const auto [entry, fresh] = locations_.try_emplace(uniform, -1);
    if (fresh) entry->second = glGetUniformLocation(id_, uniform);
    ENSURE(entry->second >= 0, "program ", name_, " has no uniform ", uniform);
    return entry->second;
}

void GlProgram::set_texture(const char* sampler, int unit, GLenum target, GLuint texture) const {
    glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    glBindTexture(target, texture);
    set(sampler, unit);
}

void GlBuffer::upload(std::span<const std::byte> bytes, GLenum target) {
    glBindBuffer(target, id_);
    if (bytes.size() > capacity_) {
        glBufferData(target, static_cast<GLsizeiptr>(bytes.size()), bytes.data(), GL_DYNAMIC_DRAW);
        capacity_ = bytes.size();
    } else if (!bytes.empty()) {
        glBufferSubData(target, 0, static_cast<GLsizeiptr>(bytes.size()), bytes.data());
    }
}

void GlVertexArray::attribute(GLuint index, const GlBuffer& buffer, int components, GLenum type, int stride,
                              std::size_t offset, GLuint divisor) const {
    bind();
    glBindBuffer(GL_ARRAY_BUFFER, buffer.id());
    glVertexAttribPointer(index, components, type, type == GL_FLOAT ? GL_FALSE : GL_TRUE, stride,
                          reinterpret_cast<const void*>(offset));
    glVertexAttribDivisor(index, divisor);
    glEnableVertexAttribArray(index);
}

void GlTexture::allocate(int width, int height, GLenum format, GLint filter) {
    glBindTexture(GL_TEXTURE_2D, id_);
    if (width != width_ || height != height_ || format != format_) {
        const bool depth = format == GL_DEPTH_COMPONENT32F || format == GL_DEPTH_COMPONENT24;
        glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(format), width, height, 0,
                     depth ? GL_DEPTH_COMPONENT : GL_RGBA, GL_FLOAT, nullptr);
        width_ = width, height_ = height, format_ = format;
    }
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void GlFramebuffer::bind(const GlTexture* colour, const GlTexture* depth) const {
    glBindFramebuffer(GL_FRAMEBUFFER, id_);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour ? colour->id() : 0, 0);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth ? depth->id() : 0, 0);
    const GLenum target = colour ? GL_COLOR_ATTACHMENT0 : GL_NONE;
    glDrawBuffers(1, &target);
    glReadBuffer(target);
    const GlTexture& size = colour ? *colour : *depth;
    glViewport(0, 0, size.width(), size.height());
    const GLenum status = glCheckFramebufferStatus(GL_FRAMEBUFFER);
    ENSURE(status == GL_FRAMEBUFFER_COMPLETE, "framebuffer status ", status);
}

}  // namespace tetfront
