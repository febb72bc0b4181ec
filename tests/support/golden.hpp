#pragma once
// Golden files: bytes that must not change by accident. TETFRONT_UPDATE_GOLDEN=1 writes them anew; look at the
// difference before committing it.

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/project.hpp"

namespace tetfront {

inline void expect_golden(const std::string& name, std::string_view bytes) {
    const auto file = source_folder() / "tests" / "golden" / name;
    if (std::getenv("TETFRONT_UPDATE_GOLDEN")) {
        std::ofstream out(file, std::ios::binary);
        out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        ASSERT_TRUE(out.good()) << file;
        return;
    }
    std::ifstream in(file, std::ios::binary);
    ASSERT_TRUE(in.good()) << file << " is missing";
    const std::string golden{std::istreambuf_iterator<char>(in), {}};
    EXPECT_TRUE(golden == bytes) << name << ": " << bytes.size() << " bytes, and " << golden.size()
                                 << " in the golden file; first difference at byte "
                                 << std::mismatch(golden.begin(), golden.end(), bytes.begin(), bytes.end()).first -
                                        golden.begin();
}

}  // namespace tetfront
