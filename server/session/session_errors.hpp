#pragma once
// What was thrown, as clients are told. Only for session*.cpp.

#include "engine/base/error.hpp"
#include "server/session/command.hpp"

#include <exception>
#include <filesystem>
#include <string>

namespace tetfront {

/// Of files only the name: where they lie on the server is nobody's business.
inline CommandError refusal(const InputError& error) {
    const std::string file = std::filesystem::path(error.file).filename().string();
    return {"failed", error.where, (file.empty() ? "" : file + ": ") + error.problem + (error.remedy.empty() ? "" : "; " + error.remedy)};
}

inline std::string text_of(const std::exception_ptr& error) {
    try {
        std::rethrow_exception(error);
    } catch (const std::exception& e) {
        return e.what();
    } catch (...) {
        return "unknown error";
    }
}

}  // namespace tetfront
