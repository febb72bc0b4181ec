#include "engine/material/voxel_image.hpp"

#include "engine/base/error.hpp"
#include "engine/material/stiffness.hpp"
#include "tests/support/temporary_folder.hpp"

#include <numeric>

#include <gtest/gtest.h>
#include <zlib.h>

namespace tetfront {
namespace {

namespace fs = std::filesystem;

class VoxelFiles : public testing::Test {
 protected:
    fs::path write(const std::string& name, const std::string& bytes) { return folder_.write(name, bytes); }
    static std::string gzip(const std::string& bytes) {
        z_stream stream{};
        deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
        std::string out(bytes.size() + 1000, '\0');
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
        stream.avail_in = static_cast<uInt>(bytes.size());
        stream.next_out = reinterpret_cast<Bytef*>(out.data());
        stream.avail_out = static_cast<uInt>(out.size());
        EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
        out.resize(stream.total_out);
        deflateEnd(&stream);
        return out;
    }
    std::string error_of(const std::string& bytes) {
        try {
            read_voxel_image(write("bad.nrrd", bytes));
        } catch (const InputError& e) {
            return e.what();
        }
        return "no error";
    }
    static std::string nrrd(const std::string& fields) { return "NRRD0004\n# a comment\n" + fields + "\n"; }

    TemporaryFolder folder_;
};

/// 0, 1, 2 ... as n bytes.
std::string ramp(int n) {
    std::string bytes(static_cast<std::size_t>(n), '\0');
    std::iota(bytes.begin(), bytes.end(), '\0');
    return bytes;
}
const std::string uchar_header =
    "type: uchar\ndimension: 3\nsizes: 2 3 4\nspace directions: (0.5,0,0) (0,1,0) (0,0,2)\n"
    "space origin: (10,20,30)\nkey:=value\n";

TEST_F(VoxelFiles, NrrdRawAndGzipHaveTheSameVoxels) {
    for (const std::string& bytes : {nrrd(uchar_header + "encoding: raw\n") + ramp(24),
                                     nrrd(uchar_header + "encoding: gzip\n") + gzip(ramp(24))}) {
        const VoxelImage image = read_voxel_image(write("a.nrrd", bytes));
        EXPECT_EQ(image.size, (std::array{2, 3, 4}));
        EXPECT_EQ(image.at({1, 2, 3}), 23);
        EXPECT_EQ(image.at({1, 0, 0}), 1);
        EXPECT_EQ(image.at({0, 0, 1}), 6);
        EXPECT_TRUE(image.continuous_index({10.5, 22, 34}).isApprox(Vec3(1, 2, 2)));
        EXPECT_TRUE(image.contains(image.continuous_index({9.8, 20, 30})));
        EXPECT_FALSE(image.contains(image.continuous_index({9.7, 20, 30})));
    }
}

TEST_F(VoxelFiles, NrrdDetachedBigEndianAndCrLf) {
    write("voxels.raw", std::string("\x01\x00\x00\x02", 4));
    const VoxelImage image = read_voxel_image(
        write("a.nhdr",
              "NRRD0001\r\ntype: short\r\ndimension: 3\r\nsizes: 2 1 1\r\nspacings: 3 1 1\r\nendian: big\r\n"
              "encoding: raw\r\ndata file: voxels.raw\r\n"));
    EXPECT_EQ(image.at({0, 0, 0}), 256);
    EXPECT_EQ(image.at({1, 0, 0}), 2);
    EXPECT_EQ(image.directions(0, 0), 3);
}

TEST_F(VoxelFiles, InrPlainAndGzip) {
    std::string header =
        "#INRIMAGE-4#{\nXDIM=2\nYDIM=3\nZDIM=4\nVDIM=1\nTYPE=unsigned fixed\nPIXSIZE=8 bits\n"
        "SCALE=2**0\nCPU=decm\nVX=0.5\nVY=1\nVZ=2\n";
    header.resize(256 - 4, '\n');
    const std::string bytes = header + "##}\n" + ramp(24);
    for (const std::string& file : {bytes, gzip(bytes)}) {
        const VoxelImage image = read_voxel_image(write("a.inr", file));
        EXPECT_EQ(image.size, (std::array{2, 3, 4}));
        EXPECT_EQ(image.at({1, 2, 3}), 23);
        EXPECT_EQ(image.directions(2, 2), 2);
    }
}

TEST_F(VoxelFiles, BadFilesSayWhatIsWrong) {
    const auto expect = [&](const std::string& bytes, const std::string& part) {
        const std::string error = error_of(bytes);
        EXPECT_NE(error.find(part), std::string::npos) << error;
    };
    expect("hello", "not an image");
    expect(nrrd("type: uchar\ndimension: 3\nencoding: raw\n"), "'sizes'");
    expect(nrrd("type: block\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n") + "x", "'type'");
    expect(nrrd("type: uchar\ndimension: 4\nsizes: 1 1 1 1\nencoding: raw\n") + "x", "'dimension'");
    expect(nrrd("type: uchar\ndimension: 3\nsizes: 0 1 1\nencoding: raw\n") + "x", "'sizes'");
    expect(nrrd("type: uchar\ndimension: 3\nsizes: 1 1\nencoding: raw\n") + "x", "'sizes'");
    expect(nrrd("type: uchar\ndimension: 3\nsizes: 1 1 1\nencoding: bzip2\n") + "x", "'encoding'");
    expect(nrrd("type: short\ndimension: 3\nsizes: 1 1 1\nencoding: raw\n") + "xx", "'endian'");
    expect(nrrd("type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n") + "1234567", "7 of 8 bytes");
    expect(nrrd("type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n") + gzip(ramp(8)).substr(0, 15),
           "ends early");
    expect(nrrd("type: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: gzip\n") + gzip(ramp(9)), "more bytes");
    expect(nrrd("type: uchar\ndimension: 3\nsizes: 1 1 1\nspacings: 0 1 1\nencoding: raw\n") + "x", "do not span");
    expect("#INRIMAGE-4#{\nXDIM=2\n", "no end");
    EXPECT_THROW(read_voxel_image(folder_.path() / "missing.nrrd"), InputError);
}

std::shared_ptr<VoxelImage> half_and_half() {
    auto image = std::make_shared<VoxelImage>();
    image->source = "labels";
    image->size = {4, 4, 4};
    image->data.assign(64, std::byte{1});
    for (std::size_t k = 0; k < 64; ++k)
        if (k % 4 >= 2) image->data[k] = std::byte{2};
    image->place(Vec3::Constant(0.125), Mat3::Identity() * 0.25);  // the unit cube
    return image;
}
const std::array<Vec3, 4> small_tet = {{{0.4, 0.1, 0.1}, {0.6, 0.1, 0.1}, {0.4, 0.3, 0.1}, {0.4, 0.1, 0.3}}};

TEST(VoxelMaterial, LabelsChooseMaterialsAndLeavesIntegrateThem) {
    const StiffnessFunction f(labels(half_and_half(), {{1, 0}, {2, 1}}),
                              {{.young = constant(1e4)}, {.young = constant(1e6)}});
    EXPECT_EQ(f.at({0.2, 0.5, 0.5}, TetId{0}).elasticity, isotropic(1e4, 0.3));
    EXPECT_EQ(f.at({0.7, 0.5, 0.5}, TetId{0}).elasticity, isotropic(1e6, 0.3));
    // The jump at x = 0.5 leaves (1/2)^3 of the tet on the stiff side.
    EXPECT_NEAR(representative_young(mean_material(f, small_tet, TetId{0}).elasticity), 1e4 + 0.125 * (1e6 - 1e4), 1e4);
}

TEST(VoxelMaterial, HolesAndPositionsOutsideAreNamed) {
    const auto message = [](const Zones& zones, const Vec3& x) -> std::string {
        try {
            zones->zone(x, TetId{0});
        } catch (const InputError& e) {
            return e.what();
        }
        return "no error";
    };
    const Zones incomplete = labels(half_and_half(), {{1, 0}});
    EXPECT_NE(message(incomplete, {0.7, 0.1, 0.1}).find("voxel (2, 0, 0)"), std::string::npos);
    EXPECT_NE(message(incomplete, {0.7, 0.1, 0.1}).find("label 2"), std::string::npos);
    EXPECT_NE(message(incomplete, {0.2, 0.1, 1.5}).find("outside of the image"), std::string::npos);
    const Zones complete = labels(half_and_half(), {{1, 0}}, 5);
    EXPECT_EQ(complete->zone({0.7, 0.1, 0.1}, TetId{0}), 5);
    EXPECT_EQ(complete->zone({0.2, 0.1, 1.5}, TetId{0}), 5);
}

TEST(VoxelMaterial, AnImageCoversItsWholeBox) {
    VoxelImage image;
    image.size = {2, 3, 4};
    image.data.resize(24);
    image.place(Vec3(0.05, 0.05, 0.05), Mat3::Identity() / 10);
    for (int corner = 0; corner < 8; ++corner) {
        const Vec3 end((corner & 1) * 0.2, (corner >> 1 & 1) * 0.3, (corner >> 2) * 0.4);
        EXPECT_TRUE(image.contains(image.continuous_index(end))) << end.transpose();
        EXPECT_FALSE(image.contains(image.continuous_index(end + 1e-6 * (end - Vec3(0.1, 0.15, 0.2)))));
    }
}

TEST(VoxelMaterial, ScalarsAreInterpolated) {
    const Scalar nearest = voxel_scalar(half_and_half(), VoxelSampling::nearest, 10);
    const Scalar linear = voxel_scalar(half_and_half(), VoxelSampling::linear, 10);
    EXPECT_EQ(nearest->at({0.49, 0.5, 0.5}, TetId{0}), 10);
    EXPECT_EQ(nearest->at({0.51, 0.5, 0.5}, TetId{0}), 20);
    EXPECT_NEAR(linear->at({0.5, 0.5, 0.5}, TetId{0}), 15, 1e-12);
    EXPECT_NEAR(linear->at({-1, 0.5, 0.5}, TetId{0}), 10, 1e-12);
    EXPECT_NEAR(linear->at({2, 0.5, 0.5}, TetId{0}), 20, 1e-12);
    EXPECT_TRUE(nearest->constant_within({Vec3(0.01, 0, 0), Vec3(0.45, 1 - 1e-9, 1 - 1e-9)}, TetId{0}));
    EXPECT_FALSE(linear->constant_within({Vec3(0.01, 0, 0), Vec3(0.45, 1 - 1e-9, 1 - 1e-9)}, TetId{0}));
}

TEST(VoxelMaterial, NotANumberIsNamed) {
    auto image = std::make_shared<VoxelImage>();
    image->source = "field";
    image->size = {2, 1, 1};
    image->type = VoxelImage::Type::float32;
    const std::array<float, 2> values = {1, std::numeric_limits<float>::quiet_NaN()};
    image->data.resize(8);
    std::memcpy(image->data.data(), values.data(), 8);
    try {
        voxel_scalar(image, VoxelSampling::linear);
        FAIL() << "no error";
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("voxel (1, 0, 0)"), std::string::npos) << e.what();
    }
}

}  // namespace
}  // namespace tetfront
