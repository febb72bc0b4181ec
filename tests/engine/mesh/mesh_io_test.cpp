#include "engine/mesh/mesh_io.hpp"

#include "engine/base/error.hpp"
#include "tests/engine/mesh/shapes.hpp"
#include "tests/support/temporary_folder.hpp"

#include <cstring>
#include <sstream>
#include <string>

#include <assimp/Exporter.hpp>
#include <assimp/material.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>

namespace tetfront {
namespace {

const SurfaceMesh& ball() {
    static const SurfaceMesh mesh = test_surfaces::sphere({1, 0, 0}, 2, 2);
    return mesh;
}

std::string obj(const SurfaceMesh& mesh) {
    std::ostringstream out;
    for (const Vec3& x : mesh.positions) out << "v " << x.transpose() << '\n';
    for (const auto& t : mesh.triangles) out << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    return out.str();
}
std::string off(const SurfaceMesh& mesh) {
    std::ostringstream out;
    out << "OFF\n" << mesh.positions.size() << ' ' << mesh.triangles.size() << " 0\n";
    for (const Vec3& x : mesh.positions) out << x.transpose() << '\n';
    for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    return out.str();
}
std::string ply(const SurfaceMesh& mesh) {
    std::ostringstream out;
    out << "ply\nformat ascii 1.0\nelement vertex " << mesh.positions.size()
        << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << mesh.triangles.size()
        << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const Vec3& x : mesh.positions) out << x.transpose() << '\n';
    for (const auto& t : mesh.triangles) out << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
    return out.str();
}
std::string stl_ascii(const SurfaceMesh& mesh) {
    std::ostringstream out;
    out << "solid ball\n";
    for (const auto& t : mesh.triangles) {
        out << "facet normal 0 0 0\nouter loop\n";
        for (std::int32_t v : t) out << "vertex " << mesh.positions[static_cast<std::size_t>(v)].transpose() << '\n';
        out << "endloop\nendfacet\n";
    }
    out << "endsolid ball\n";
    return out.str();
}
std::string stl_binary(const SurfaceMesh& mesh) {
    std::string out(80, '\0');
    const auto append = [&](const auto& value) { out.append(reinterpret_cast<const char*>(&value), sizeof value); };
    append(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (const auto& t : mesh.triangles) {
        for (int i = 0; i < 3; ++i) append(0.0F);
        for (std::int32_t v : t)
            for (int i = 0; i < 3; ++i) append(static_cast<float>(mesh.positions[static_cast<std::size_t>(v)][i]));
        append(std::uint16_t{0});
    }
    return out;
}

std::string complaint(const std::filesystem::path& file, double scale = 1) {
    try {
        read_surface(file, scale);
    } catch (const InputError& error) {
        return error.what();
    }
    return "";
}

TEST(ReadSurface, AllFormatsGiveTheSameBall) {
    const TemporaryFolder directory;
    const std::pair<const char*, std::string> files[] = {{"a.obj", obj(ball())},
                                                         {"a.off", off(ball())},
                                                         {"a.ply", ply(ball())},
                                                         {"ascii.stl", stl_ascii(ball())},
                                                         {"binary.stl", stl_binary(ball())}};
    for (const auto& [name, bytes] : files) {
        const ImportedSurface read = read_surface(directory.write(name, bytes), 0.1);
        EXPECT_EQ(read.mesh.positions.size(), ball().positions.size()) << name;
        EXPECT_EQ(read.mesh.triangles.size(), ball().triangles.size()) << name;
        EXPECT_EQ(read.repairs.open_edges, 0u) << name;
        EXPECT_EQ(read.repairs.parts, 1u) << name;
        EXPECT_NEAR(test_surfaces::surface_volume(read.mesh), 1e-3 * test_surfaces::surface_volume(ball()), 1e-6) << name;
    }
}

/// The ball as assimp writes it in a format of its own choice of encoding.
std::filesystem::path exported(const std::filesystem::path& file, const char* format) {
    aiScene scene;
    auto* mesh = new aiMesh;  // the scene owns what it points to
    mesh->mPrimitiveTypes = aiPrimitiveType_TRIANGLE;
    mesh->mNumVertices = static_cast<unsigned>(ball().positions.size());
    mesh->mVertices = new aiVector3D[mesh->mNumVertices];
    for (unsigned v = 0; v < mesh->mNumVertices; ++v) {
        const Vec3& x = ball().positions[v];
        mesh->mVertices[v] = {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
    }
    mesh->mNumFaces = static_cast<unsigned>(ball().triangles.size());
    mesh->mFaces = new aiFace[mesh->mNumFaces];
    for (unsigned f = 0; f < mesh->mNumFaces; ++f) {
        mesh->mFaces[f].mNumIndices = 3;
        mesh->mFaces[f].mIndices = new unsigned[3];
        for (unsigned i = 0; i < 3; ++i) mesh->mFaces[f].mIndices[i] = static_cast<unsigned>(ball().triangles[f][i]);
    }
    scene.mNumMeshes = 1;
    scene.mMeshes = new aiMesh*[1]{mesh};
    scene.mNumMaterials = 1;
    scene.mMaterials = new aiMaterial*[1]{new aiMaterial};
    scene.mRootNode = new aiNode("root");
    scene.mRootNode->mNumMeshes = 1;
    scene.mRootNode->mMeshes = new unsigned[1]{0};
    Assimp::Exporter exporter;
    EXPECT_EQ(exporter.Export(&scene, format, file.string()), AI_SUCCESS) << format << ": " << exporter.GetErrorString();
    return file;
}

TEST(ReadSurface, BinaryAndSceneFormatsGiveTheSameBall) {
    const TemporaryFolder directory;
    const std::pair<const char*, const char*> files[] = {{"a.glb", "glb2"}, {"a.gltf", "gltf2"}, {"a.dae", "collada"},
                                                         {"a.fbx", "fbxa"}, {"binary.ply", "plyb"}};
    for (const auto& [name, format] : files) {
        const ImportedSurface read = read_surface(exported(directory.path() / name, format), 0.1);
        EXPECT_EQ(read.mesh.positions.size(), ball().positions.size()) << name;
        EXPECT_EQ(read.mesh.triangles.size(), ball().triangles.size()) << name;
        EXPECT_EQ(read.repairs.open_edges, 0u) << name;
        EXPECT_NEAR(test_surfaces::surface_volume(read.mesh), 1e-3 * test_surfaces::surface_volume(ball()), 1e-6) << name;
    }
}

TEST(ReadSurface, NodesOfGltfAreTransformedAndMerged) {
    // One tetrahedron used by two nodes, one of them moved and doubled.
    const TemporaryFolder directory;
    const float positions[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const std::uint16_t indices[] = {1, 2, 3, 0, 3, 2, 0, 1, 3, 0, 2, 1};
    std::string buffer(reinterpret_cast<const char*>(positions), sizeof positions);
    buffer.append(reinterpret_cast<const char*>(indices), sizeof indices);
    directory.write("data.bin", buffer);
    const auto file = directory.write("two.gltf", R"({"asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"mesh": 0, "translation": [5, 0, 0], "scale": [2, 2, 2]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"uri": "data.bin", "byteLength": 72}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 24}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0,0,0], "max": [1,1,1]},
                      {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"}]})");
    const ImportedSurface read = read_surface(file);
    EXPECT_EQ(read.repairs.parts, 2u);
    EXPECT_EQ(read.repairs.components, 2u);
    EXPECT_NEAR(test_surfaces::surface_volume(read.mesh), 1.0 / 6 + 8.0 / 6, 1e-6);
    double highest = 0;
    for (const Vec3& x : read.mesh.positions) highest = std::max(highest, x[0]);
    EXPECT_NEAR(highest, 7, 1e-6);
}

TEST(ReadSurface, SeveralFilesMakeOneSurfaceWhoseHalvesAreWelded) {
    const TemporaryFolder directory;
    const auto half = [&](double side) {
        return obj(test_surfaces::part(ball(), [&](const Vec3& c) { return side * c[2] > 0; }));
    };
    const std::vector<std::filesystem::path> files = {directory.write("above.obj", half(1)), directory.write("below.obj", half(-1))};
    const ImportedSurface read = read_surfaces(files, 0.5);
    EXPECT_EQ(read.repairs.parts, 2u);
    EXPECT_EQ(read.repairs.open_edges, 0u);
    EXPECT_EQ(read.repairs.components, 1u);
    EXPECT_NEAR(test_surfaces::surface_volume(read.mesh), test_surfaces::surface_volume(ball()) / 8, 1e-4);
    const std::vector<std::filesystem::path> broken = {files[0], directory.write("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")};
    try {
        read_surfaces(broken);
        ADD_FAILURE() << "accepted";
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("nan.obj"), std::string::npos) << error.what();
    }
}

TEST(ReadSurface, PolygonsAreTriangulated) {
    const TemporaryFolder directory;
    const auto file = directory.write("cube.obj",
                                      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
                                      "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n");
    const ImportedSurface read = read_surface(file);
    EXPECT_EQ(read.mesh.triangles.size(), 12u);
    EXPECT_NEAR(test_surfaces::surface_volume(read.mesh), 1, 1e-6);
}

TEST(ReadSurface, UnusableFilesSayWhatToDo) {
    const TemporaryFolder directory;
    const auto& path = directory.path();
    EXPECT_NE(complaint(path / "nothing.obj").find("does not exist"), std::string::npos);
    EXPECT_NE(complaint(path).find("is not a file"), std::string::npos);
    EXPECT_NE(complaint(directory.write("empty.obj", "")).find("is empty"), std::string::npos);
    EXPECT_NE(complaint(directory.write("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")), "");
    EXPECT_NE(complaint(directory.write("flat.obj", "v 0 0 0\nv 0 0 0\nv 0 1 0\nf 1 2 3\n")).find("no triangles"),
              std::string::npos);
    EXPECT_NE(complaint(directory.write("noise.ply", std::string(2000, '\x9d'))).find("cannot be read as a surface"),
              std::string::npos);
    EXPECT_NE(complaint(directory.write("noise.xyzzy", "hello")).find("cannot be read as a surface"),
              std::string::npos);
    const auto good = directory.write("good.obj", obj(ball()));
    EXPECT_NE(complaint(good, 0).find("scale"), std::string::npos);
    EXPECT_NE(complaint(good, -1).find("scale"), std::string::npos);
    EXPECT_EQ(complaint(good), "");
    std::string cut = stl_binary(ball());
    cut.resize(cut.size() / 2);
    EXPECT_NE(complaint(directory.write("cut.stl", cut)), "");
}

TEST(ReadSurface, HugeFilesAreRefusedUnread) {
    const TemporaryFolder directory;
    const auto file = directory.write("huge.obj", "v 0 0 0\n");
    std::filesystem::resize_file(file, max_surface_file + 1);  // sparse
    EXPECT_NE(complaint(file).find("MiB"), std::string::npos) << complaint(file);
    for (const char* name : {"huge.stl", "huge.ply", "huge.off", "huge.glb", "huge.fbx", "huge.dae"}) {
        const auto rubbish = directory.write(name, "rubbish");
        std::filesystem::resize_file(rubbish, std::uintmax_t{1} << 30);
        EXPECT_NE(complaint(rubbish).find("MiB"), std::string::npos) << complaint(rubbish);
    }
}

}  // namespace
}  // namespace tetfront
