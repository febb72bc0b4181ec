#include "engine/mesh/tet_file.hpp"

#include "engine/base/error.hpp"
#include "engine/mesh/tet_readers.hpp"
#include "engine/mesh/tet_repair.hpp"
#include "tests/engine/mesh/tet_files.hpp"
#include "tests/support/temporary_folder.hpp"

#include <algorithm>
#include <random>
#include <string>

#include <sys/resource.h>

#include <gtest/gtest.h>

namespace tetfront {
namespace {

/// Reads the bytes as the file of this name would be read.
ImportedTets read_as(const std::string& name, const std::string& bytes) {
    if (name.ends_with(".msh")) return finish(read_gmsh(bytes, name), name, 1);
    if (name.ends_with(".mesh")) return finish(read_medit(bytes, name), name, 1);
    if (name.ends_with(".vtk")) return finish(read_vtk_legacy(bytes, name), name, 1);
    return finish(read_vtu(bytes, name), name, 1);
}
std::string complaint(const std::string& name, const std::string& bytes) {
    try {
        read_as(name, bytes);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}
std::string complaint(const std::filesystem::path& file) {
    try {
        read_tet_mesh(file);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}
#define EXPECT_COMPLAINT(expression, part)                                            \
    do {                                                                              \
        const std::string said = (expression);                                        \
        EXPECT_NE(said.find(part), std::string::npos) << "it said: '" << said << "'"; \
    } while (false)

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return at == std::string::npos ? text : text.replace(at, from.size(), to);
}

/// The sample: positions scaled, tet 2 turned around, vertex 0 gone.
void expect_sample(const ImportedTets& read, double scale, const std::string& name) {
    SCOPED_TRACE(name);
    const TetMesh sample = tet_files::sample();
    EXPECT_NO_THROW(validate(read.mesh));
    EXPECT_EQ(read.repairs.inverted_tets, 1u);
    EXPECT_EQ(read.repairs.unused_vertices, 1u);
    ASSERT_EQ(read.mesh.corners.size(), sample.corners.size());
    ASSERT_EQ(read.mesh.positions.size(), sample.positions.size() - 1);
    EXPECT_EQ(read.mesh.region, sample.region);
    for (TetId t : ids<TetId>(sample.corners.size())) {
        // The same corners in some order.
        std::vector<VertexId> expected, got;
        for (VertexId v : sample.corners[t]) expected.emplace_back(v.value - 1);
        for (VertexId v : read.mesh.corners[t]) got.push_back(v);
        std::sort(expected.begin(), expected.end());
        std::sort(got.begin(), got.end());
        EXPECT_EQ(got, expected);
    }
    for (VertexId v : ids<VertexId>(read.mesh.positions.size()))
        EXPECT_LT((read.mesh.positions[v] - scale * sample.positions[VertexId(v.value + 1)]).norm(), 1e-12);
}

TEST(TetFile, EveryVariantGivesTheSameMesh) {
    const TemporaryFolder directory;
    const auto files = tet_files::all(tet_files::sample());
    EXPECT_GT(files.size(), 25u);
    for (const auto& [name, bytes] : files) {
        const auto file = directory.write(name, bytes);
        ASSERT_TRUE(is_tet_file(file));
        const ImportedTets read = read_tet_mesh(file, 0.25);
        expect_sample(read, 0.25, name);
        EXPECT_EQ(read.repairs.ignored_cells, name == "gmsh4_binary.msh" ? 0u : 1u) << name;
    }
}

TEST(TetFile, TetgenPairIsReadByEitherName) {
    for (int first : {0, 1}) {
        const TemporaryFolder directory;
        const auto [node, ele] = tet_files::tetgen(tet_files::sample(), first);
        directory.write("box.node", node);
        EXPECT_COMPLAINT(complaint(directory.path() / "box.node"), "box.ele: does not exist");
        directory.write("box.ele", ele);
        expect_sample(read_tet_mesh(directory.path() / "box.node"), 1, "node");
        expect_sample(read_tet_mesh(directory.path() / "box.ele"), 1, "ele");
    }
}

TEST(TetFile, PiecesOfVtuAreWelded) {
    const ImportedTets read = read_as("a.vtu", tet_files::vtu(tet_files::sample(), {tet_files::VtuFormat::ascii}, 2));
    EXPECT_EQ(read.repairs.welded_vertices, 13u);
    EXPECT_EQ(read.mesh.positions.size(), 12u);
    EXPECT_EQ(read.mesh.corners.size(), 12u);
    EXPECT_EQ(std::ranges::max(connected_pieces(read.mesh)), 0);
}

TEST(TetFile, QuadraticTetsAreTakenByTheirCorners) {
    const std::string file =
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n10\n1 0 0 0\n2 2 0 0\n3 0 2 0\n4 0 0 2\n5 1 0 0\n6 1 1 0\n7 0 1 "
        "0\n"
        "8 0 0 1\n9 0 1 1\n10 1 0 1\n$EndNodes\n$Elements\n1\n1 11 2 1 1 1 2 3 4 5 6 7 8 9 10\n$EndElements\n";
    const ImportedTets read = read_as("a.msh", file);
    EXPECT_EQ(read.repairs.straightened_tets, 1u);
    EXPECT_EQ(read.repairs.unused_vertices, 6u);
    EXPECT_EQ(read.mesh.positions.size(), 4u);
    EXPECT_NE(describe(read.repairs).find("quadratic"), std::string::npos);
}

TEST(TetFile, MeshesWithoutRegionsHaveNone) {
    TetMesh mesh = tet_files::sample();
    for (auto& region : mesh.region) region = 0;
    EXPECT_TRUE(read_as("a.mesh", tet_files::medit(mesh)).mesh.region.empty());
    std::string unnamed = tet_files::vtk_legacy(tet_files::sample(), false, "3.0");
    EXPECT_TRUE(read_as("a.vtk", replaced(unnamed, "material", "something")).mesh.region.empty());
}

TEST(TetFile, BadTetsAreNamedByNumber) {
    const auto with = [](const auto& change) {
        TetMesh mesh = tet_files::sample();
        change(mesh);
        return complaint("a.mesh", tet_files::medit(mesh));
    };
    EXPECT_COMPLAINT(
        with([](TetMesh& m) { m.positions[m.corners[TetId{5}][0]] = m.positions[m.corners[TetId{5}][1]]; }),
        "has no volume");
    EXPECT_COMPLAINT(with([](TetMesh& m) { m.corners[TetId{4}][1] = m.corners[TetId{4}][3]; }), "tet 4: has no volume");
    EXPECT_COMPLAINT(with([](TetMesh& m) {
                         m.corners.push_back(m.corners[TetId{3}]);
                         std::swap(m.corners.back()[1], m.corners.back()[2]);
                         m.region.push_back(7);
                     }),
                     "tet 12: has the same corners as tet 3");
    EXPECT_COMPLAINT(with([](TetMesh& m) {
                         m.positions.emplace_back(0.5, 0.5, 0.4);
                         auto c = m.corners[TetId{3}];
                         c[0] = VertexId(static_cast<std::int64_t>(m.positions.size()) - 1);
                         m.corners.push_back(c);
                         m.region.push_back(7);
                     }),
                     "tet");
    EXPECT_COMPLAINT(with([](TetMesh& m) { m.corners.clear(); }), "has no tets");
}

TEST(TetFile, ErrorsNameTheLine) {
    const TetMesh sample = tet_files::sample();
    const std::string mesh = tet_files::medit(sample), msh = tet_files::gmsh2_text(sample);
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "9 9 9 0", "9 nine 9 0")),
                     "a.mesh: line 7: 'nine' is not a coordinate");
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "9 9 9 0", "9 1e999 9 0")), "line 7: '1e999' is out of range");
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "9 9 9 0", "9 nan 9 0")), "line 7: 'nan' is not finite");
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "9 9 9 0", "9 9 9 99999999999999999999")), "out of range");
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "9 9 9 0", "9 9 9 0.5")), "line 7: '0.5' is not a reference");
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "Vertices\n13", "Vertices\n4000000000000")),
                     "line 6: announces 4000000000000 vertices, but only");
    EXPECT_COMPLAINT(complaint("a.mesh", mesh.substr(0, mesh.size() - 40)), "announces 12 tetrahedra");
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "Dimension\n3", "Dimension\n2")), "two-dimensional");
    EXPECT_COMPLAINT(complaint("a.mesh", replaced(mesh, "Triangles 1\n1 2 3 4", "Prisms 1\n1 2 3 4 5 6 7")), "Prisms");
    EXPECT_COMPLAINT(complaint("a.msh", replaced(msh, "$EndNodes", "$EndNode")), "line 23: $EndNodes is expected");
    EXPECT_COMPLAINT(complaint("a.msh", replaced(msh, "2.2 0 8", "4.0 0 8")), "save it as version 2.2 or 4.1");
    EXPECT_COMPLAINT(complaint("a.msh", replaced(msh, "12 0 0 0", "10 0 0 0")), "line 11: node 10 appears twice");
    EXPECT_COMPLAINT(complaint("a.msh", replaced(msh, "1 2 2 3 3 10 12 14", "1 5 2 3 3 10 12 14 10 12 14 10 12")),
                     "are no tets");
    EXPECT_COMPLAINT(complaint("a.msh", replaced(msh, "1 2 2 3 3 10 12 14", "1 4 2 3 3 10 12 14 99")),
                     "refers to node 99");
    EXPECT_COMPLAINT(
        complaint("a.vtk", replaced(tet_files::vtk_legacy(sample, false, "3.0"), "POINTS 13", "POINTS 1300000")),
        "announces");
    EXPECT_COMPLAINT(
        complaint("a.vtk", replaced(tet_files::vtk_legacy(sample, false, "3.0"), "UNSTRUCTURED_GRID", "POLYDATA")),
        "line 4: is no unstructured grid");
    const std::string vtu = tet_files::vtu(sample, {tet_files::VtuFormat::ascii});
    EXPECT_COMPLAINT(complaint("a.vtu", replaced(vtu, "</Points>", "</Point>")), "not well-formed XML");
    EXPECT_COMPLAINT(complaint("a.vtu", replaced(vtu, "NumberOfPoints=\"13\"", "NumberOfPoints=\"12\"")),
                     "has 39 values for 36");
    EXPECT_COMPLAINT(complaint("a.vtu", replaced(vtu, "Name=\"connectivity\" NumberOfComponents=\"1\" format=\"ascii\"",
                                                 "Name=\"connectivity\" format=\"base85\"")),
                     "unknown format 'base85'");
    const auto [node, ele] = tet_files::tetgen(sample, 1);
    try {
        read_tetgen(node, "a.node", replaced(ele, " 4 1\n", " 5 1\n"), "a.ele");
        ADD_FAILURE();
    } catch (const InputError& error) {
        EXPECT_COMPLAINT(error.what(), "a.ele: line 1: a tet has 4 or 10 nodes");
    }
}

TEST(TetFile, ArraysWithoutComponentsAreSkipped) {  // found by the fuzzer: a division by zero
    const std::string file = tet_files::vtk_legacy(tet_files::sample(), false, "3.0");
    const std::string empty = replaced(file, "FIELD FieldData 1\n", "FIELD FieldData 2\nnothing 0 99 int\n");
    EXPECT_FALSE(read_as("a.vtk", empty).mesh.region.empty());
}

TEST(TetFile, VtuErrorsNameTheLineInsideOfAnArray) {
    std::string vtu = tet_files::vtu(tet_files::sample(), {tet_files::VtuFormat::ascii});
    const std::size_t at = vtu.find("9\n9\n9\n", vtu.find("MaterialIDs"));
    ASSERT_NE(at, std::string::npos);
    vtu[at] = 'x';
    const auto line = std::count(vtu.begin(), vtu.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
    EXPECT_COMPLAINT(complaint("a.vtu", vtu), "line " + std::to_string(line) + ": 'x' is not");
}

TEST(TetFile, FilesOfAnotherKindAreRefused) {
    const TemporaryFolder directory;
    EXPECT_COMPLAINT(complaint(directory.path() / "nothing.msh"), "does not exist");
    EXPECT_COMPLAINT(complaint(directory.write("a.stl", "solid")), "no extension of a tet mesh");
    for (const char* name : {"a.msh", "a.mesh", "a.vtk", "a.vtu", "a.node"}) {
        EXPECT_COMPLAINT(complaint(directory.write(name, "rubbish")), name);
        EXPECT_COMPLAINT(complaint(directory.write(name, "")), "is empty");
    }
    const auto huge = directory.write("huge.msh", "rubbish");
    std::filesystem::resize_file(huge, max_tet_file);  // sparse; the head alone refuses it
    EXPECT_COMPLAINT(complaint(huge), "is not a Gmsh file");
    std::filesystem::resize_file(huge, max_tet_file + 1);
    EXPECT_COMPLAINT(complaint(huge), "MiB");
    EXPECT_THROW(read_tet_mesh(directory.write("b.mesh", tet_files::medit(tet_files::sample())), 0), InputError);
}

/// Without reading it: a gigabyte takes a second and more.
TEST(TetFile, AGigabyteOfRubbishIsRefusedUnread) {
    const TemporaryFolder directory;
    static_cast<void>(directory.write("a.node", "1 3 0 0\n1 0 0 0\n"));
    for (const char* name : {"a.msh", "a.mesh", "a.vtk", "a.vtu", "a.ele"}) {
        const auto file = directory.write(name, "rubbish\n");
        std::filesystem::resize_file(file, std::uintmax_t{1} << 30);  // sparse
        rusage before{}, after{};
        getrusage(RUSAGE_THREAD, &before);
        const std::string refusal = complaint(file);
        getrusage(RUSAGE_THREAD, &after);
        EXPECT_COMPLAINT(refusal, name);
        const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec); };
        EXPECT_LT(seconds(after.ru_utime) + seconds(after.ru_stime) - seconds(before.ru_utime) - seconds(before.ru_stime), 0.5)
            << "s of CPU: " << name << " was read";
    }
}

TEST(TetFile, CompressionBombsAreRefused) {
    // Blocks that claim far more than zlib could ever pack into them.
    tet_files::Bytes header;
    header.put(std::uint32_t{1}).put(std::uint32_t{1} << 30).put(std::uint32_t{0}).put(std::uint32_t{4});
    std::string vtu = tet_files::vtu(tet_files::sample(), {tet_files::VtuFormat::base64, true});
    const std::size_t points = vtu.find("Name=\"Points\"");
    const std::size_t begin = vtu.find(">\n  ", points) + 4, end = vtu.find("\n</DataArray>", begin);
    vtu.replace(begin, end - begin, tet_files::base64(header.text) + tet_files::base64("abcd"));
    EXPECT_COMPLAINT(complaint("a.vtu", vtu), "claims too many bytes");
}

/// Mutated copies of valid files must be read or refused, never crash, hang or eat memory. The fuzzers in tests/fuzz do
/// the same for hours.
TEST(TetFile, MutatedFilesAreReadOrRefused) {
    std::mt19937 random(12345);
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random()) % std::max<std::size_t>(n, 1); };
    const std::string interesting[] = {
        "-1", "4294967295", "99999999999999999999", "1e400", "nan", "0", "\xff\xff\xff\xff", "$", "\"", "<"};
    std::size_t refused = 0, accepted = 0;
    const auto mutate = [&](std::string bytes) {
        for (std::size_t change = 1 + below(4); change > 0 && !bytes.empty(); --change) {
            const std::size_t at = below(bytes.size()), length = 1 + below(12);
            switch (below(6)) {
                case 0:
                    bytes[at] = static_cast<char>(random());
                    break;
                case 1:
                    bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
                    break;
                case 2:
                    bytes.erase(at, length);
                    break;
                case 3:
                    bytes.insert(at, bytes.substr(below(bytes.size()), length));
                    break;
                case 4:
                    bytes.resize(at);
                    break;
                default:
                    bytes.replace(at, std::min(length, bytes.size() - at), interesting[below(std::size(interesting))]);
            }
        }
        return bytes;
    };
    const auto attempt = [&](const auto& read) {
        try {
            read();
            ++accepted;
        } catch (const InputError&) {
            ++refused;
        }
    };
    for (const auto& [name, bytes] : tet_files::all(tet_files::sample()))
        for (int i = 0; i < 150; ++i) {
            const std::string mutated = mutate(bytes);
            attempt([&] { read_as(name, mutated); });
        }
    const auto [node, ele] = tet_files::tetgen(tet_files::sample(), 1);
    for (int i = 0; i < 300; ++i) {
        const std::string first = mutate(node), second = mutate(ele);
        attempt([&] { finish(read_tetgen(first, "a.node", second, "a.ele"), "a.ele", 1); });
    }
    EXPECT_GT(refused, 1000u);
    EXPECT_GT(accepted, 50u);
}

}  // namespace
}  // namespace tetfront
