#include "engine/mesh/mesh_io.hpp"

#include "engine/base/error.hpp"
#include "engine/mesh/file_bytes.hpp"

#include <cmath>
#include <exception>
#include <string>
#include <utility>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace tetfront {

namespace {

/// Deeper node trees than this are nonsense, and recursion must end.
constexpr int max_node_depth = 1000;

/// Appends the node's meshes and those of its children to a surface, in metres.
class Collector {
 public:
    Collector(const std::filesystem::path& file, const aiScene& scene, double scale, ImportedSurface& result)
        : file_(file.string()), scene_(scene), scale_(scale), result_(result), first_vertex_(result.mesh.positions.size()) {}

    void add(const aiNode& node, const aiMatrix4x4& parent, int depth = 0) {
        if (depth > max_node_depth) throw InputError{file_, "", "nests its nodes too deeply", "export it again"};
        const aiMatrix4x4 transformation = parent * node.mTransformation;
        for (unsigned i = 0; i < node.mNumMeshes; ++i) add(*scene_.mMeshes[node.mMeshes[i]], transformation);
        for (unsigned i = 0; i < node.mNumChildren; ++i) add(*node.mChildren[i], transformation, depth + 1);
    }

 private:
    void add(const aiMesh& mesh, const aiMatrix4x4& transformation) {
        SurfaceMesh& out = result_.mesh;
        const std::size_t offset = out.positions.size();
        if (out.triangles.size() + mesh.mNumFaces > max_surface_triangles)
            throw InputError{file_, "", "has more than " + std::to_string(max_surface_triangles) + " triangles",
                             "simplify it"};
        for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
            const aiVector3D x = transformation * mesh.mVertices[v];
            out.positions.emplace_back(scale_ * Vec3(x.x, x.y, x.z));
            if (!out.positions.back().allFinite())
                throw InputError{file_, "vertex " + std::to_string(offset - first_vertex_ + v), "is not finite or too large",
                                 "coordinates must be finite numbers"};
        }
        for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
            const aiFace& face = mesh.mFaces[f];
            if (face.mNumIndices != 3) continue;  // points and lines
            std::array<std::int32_t, 3> triangle;
            for (unsigned i = 0; i < 3; ++i) {
                if (face.mIndices[i] >= mesh.mNumVertices)
                    throw InputError{file_, "face " + std::to_string(f),
                                     "refers to vertex " + std::to_string(face.mIndices[i]),
                                     "its part has " + std::to_string(mesh.mNumVertices) + " vertices"};
                triangle[i] = static_cast<std::int32_t>(offset + face.mIndices[i]);
            }
            out.triangles.push_back(triangle);
        }
        ++result_.repairs.parts;
    }

    std::string file_;
    const aiScene& scene_;
    double scale_;
    ImportedSurface& result_;
    std::size_t first_vertex_;  // of the file
};

void append(const std::filesystem::path& file, double scale, ImportedSurface& result) {
    check_readable(file, max_surface_file);
    Assimp::Importer importer;
    importer.SetPropertyInteger(AI_CONFIG_PP_RVC_FLAGS, aiComponent_NORMALS | aiComponent_TANGENTS_AND_BITANGENTS |
                                                            aiComponent_COLORS | aiComponent_TEXCOORDS |
                                                            aiComponent_BONEWEIGHTS | aiComponent_ANIMATIONS |
                                                            aiComponent_TEXTURES | aiComponent_LIGHTS |
                                                            aiComponent_CAMERAS | aiComponent_MATERIALS);
    const aiScene* scene = nullptr;
    std::string problem;
    try {
        scene = importer.ReadFile(file.string(), aiProcess_RemoveComponent | aiProcess_Triangulate);
        if (!scene) problem = importer.GetErrorString();
    } catch (const std::exception& error) {
        problem = error.what();
    }
    if (!problem.empty()) {
        for (char& c : problem)
            if (c == '\n') c = ' ';
        throw InputError{file.string(), "", "cannot be read as a surface: " + problem,
                         "use OBJ, STL, PLY, OFF, glTF, FBX or DAE with the matching file extension"};
    }
    const std::size_t triangles = result.mesh.triangles.size();
    if (scene && scene->mRootNode) Collector(file, *scene, scale, result).add(*scene->mRootNode, aiMatrix4x4());
    if (result.mesh.triangles.size() == triangles)
        throw InputError{file.string(), "", "has no triangles", "a point cloud or a set of lines encloses nothing"};
}

}  // namespace

ImportedSurface read_surface(const std::filesystem::path& file, double scale) { return read_surfaces({&file, 1}, scale); }

ImportedSurface read_surfaces(std::span<const std::filesystem::path> files, double scale) {
    ENSURE(!files.empty(), "no files");
    const std::string first = files[0].string();
    if (!(scale > 0) || !std::isfinite(scale))
        throw InputError{first, "", "the scale " + std::to_string(scale) + " is not usable", "use a number > 0"};
    ImportedSurface result;
    for (const std::filesystem::path& file : files) append(file, scale, result);
    const std::size_t parts = result.repairs.parts;
    result.repairs = repair(result.mesh);
    result.repairs.parts = parts;
    if (result.mesh.triangles.empty())
        throw InputError{first, "", "has no triangles", "a point cloud or a set of lines encloses nothing"};
    return result;
}

}  // namespace tetfront
