// Scenes from files: small ones that the test writes, where every number is known, and Assimp's own test
// models.
#include "render/file/scene_file.h"

#include <gtest/gtest.h>

#include "core/checksum.h"
#include "render/file/gltf_json.h"
#include "render/file/scene_file_config.h"
#include "tests/render/test_gltf.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

using nlohmann::json;

const std::string kModels = "/usr/share/assimp/models/";

#define EXPECT_VEC3(actual, x_, y_, z_, tolerance)   \
  do {                                               \
    const Vec3 ld_vec = actual;                      \
    EXPECT_NEAR(ld_vec.x, x_, tolerance) << #actual; \
    EXPECT_NEAR(ld_vec.y, y_, tolerance) << #actual; \
    EXPECT_NEAR(ld_vec.z, z_, tolerance) << #actual; \
  } while (false)

constexpr FrameTimes kStart = {0, 0, 0};

class SceneFileTest : public ::testing::Test {
 protected:
  Scene scene() { return SceneFile(gltf.write(folder / "scene.gltf")).scene(kStart); }
  Material material(const json& description) {
    gltf.root["materials"][0] = description;
    const Scene read = scene();
    whole = read;
    return read.materials[static_cast<size_t>(read.objects[0].material)];
  }

  TemporaryFolder folder;
  TestGltf gltf;
  Scene whole;
};

TEST_F(SceneFileTest, NodesPlaceTheirMeshes) {
  // Turned by 90 degrees about y, scaled by 2, moved; and once more as a mirror image.
  const float h = std::sqrt(0.5F);
  gltf.root["nodes"][0].update(
      {{"rotation", {0, h, 0, h}}, {"scale", {2, 2, 2}}, {"translation", {10, 0, 0}}, {"name", "same"}});
  gltf.add_node({{"mesh", 0}, {"scale", {-1, 1, 1}}, {"name", "same"}});
  const Scene read = scene();
  ASSERT_EQ(read.objects.size(), 2U);
  const bool first_is_turned = read.objects[0].mesh.positions[0].x > 5;
  const Mesh& turned = read.objects[first_is_turned ? 0 : 1].mesh;
  const Mesh& mirrored = read.objects[first_is_turned ? 1 : 0].mesh;
  EXPECT_VEC3(turned.positions[0], 10, -2, 2, 1e-5F);
  EXPECT_VEC3(turned.positions[2], 10, 2, -2, 1e-5F);
  // The square still faces +z when it is mirrored in x: its triangles were turned round.
  const auto& [a, b, c] = mirrored.triangles[0];
  const Vec3 normal =
      cross(mirrored.positions[b] - mirrored.positions[a], mirrored.positions[c] - mirrored.positions[a]);
  EXPECT_GT(normal.z, 0);
  // Texture coordinates point upwards here: the corner at the top has v = 1.
  ASSERT_EQ(turned.uvs.size(), 4U);
  EXPECT_NEAR(turned.uvs[2].y, 1, 1e-6F);
  EXPECT_NEAR(turned.uvs[0].y, 0, 1e-6F);
  EXPECT_TRUE(read.objects[0].motion.still());
}

TEST_F(SceneFileTest, CamerasStandWhereTheirNodesAre) {
  gltf.root["cameras"] = {
      {{"type", "perspective"},
       {"name", "Front"},
       {"perspective", {{"yfov", 0.75}, {"znear", 0.1}, {"aspectRatio", 1.5}}},
       {"extras", {{"ld", {{"aperture_radius", 0.25}, {"focus_distance", 4}}}}}},
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"zfar", 9}, {"znear", 1}}}}};
  gltf.add_node({{"camera", 0}, {"translation", {1, 2, 3}}});
  gltf.add_node({{"camera", 1}});
  gltf.add_node({{"camera", 0}, {"rotation", {0, 1, 0, 0}}, {"scale", {3, 3, 3}}});  // looks to +z
  const SceneFile file(gltf.write(folder / "scene.gltf"));
  ASSERT_EQ(file.camera_count(), 2U);
  EXPECT_EQ(file.camera_name(0), "Front");
  const Camera first = file.camera(0, kStart), second = file.camera(1, kStart);
  EXPECT_FLOAT_EQ(first.fov, 0.75F);
  EXPECT_FLOAT_EQ(first.lens_radius, 0.25F);
  EXPECT_FLOAT_EQ(first.focus_distance, 4);
  EXPECT_VEC3(first.position, 1, 2, 3, 1e-6F);
  EXPECT_VEC3(first.axes.z, 0, 0, 1, 1e-6F);
  EXPECT_VEC3(second.axes.z, 0, 0, -1, 1e-6F);
  EXPECT_VEC3(second.axes.x, -1, 0, 0, 1e-6F);
  EXPECT_VEC3(second.axes.y, 0, 1, 0, 1e-6F);
  EXPECT_FALSE(first.shutter);
  EXPECT_FALSE(first.close.has_value());
}

TEST_F(SceneFileTest, PunctualLightsKeepTheirNumbers) {
  gltf.root["extensionsUsed"] = {"KHR_lights_punctual"};
  gltf.root["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "point"}, {"intensity", 50}, {"color", {1, 0.5, 0}}, {"range", 2}},
      {{"type", "spot"}, {"intensity", 8}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}},
      {{"type", "directional"}, {"intensity", 3}}};
  const float h = std::sqrt(0.5F);
  const auto shines = [](int light) { return json{{"KHR_lights_punctual", {{"light", light}}}}; };
  gltf.add_node({{"extensions", shines(0)}, {"translation", {0, 5, 0}}});
  gltf.add_node({{"extensions", shines(1)}, {"rotation", {-h, 0, 0, h}}});  // -z becomes -y
  gltf.add_node({{"extensions", shines(2)}, {"rotation", {-h, 0, 0, h}}});
  const Scene read = scene();
  ASSERT_EQ(read.point_lights.size(), 2U);
  EXPECT_VEC3(read.point_lights[0].position, 0, 5, 0, 1e-6F);
  EXPECT_VEC3(read.point_lights[0].intensity, 50, 25, 0, 1e-5F);
  EXPECT_EQ(read.point_lights[0].cos_outer, -1);
  EXPECT_VEC3(read.point_lights[1].direction, 0, -1, 0, 1e-6F);
  EXPECT_NEAR(read.point_lights[1].cos_inner, std::cos(0.25F), 1e-6F);
  EXPECT_NEAR(read.point_lights[1].cos_outer, std::cos(0.5F), 1e-6F);
  ASSERT_EQ(read.directional_lights.size(), 1U);
  EXPECT_VEC3(read.directional_lights[0].direction, 0, 1, 0, 1e-6F);
  EXPECT_VEC3(read.directional_lights[0].irradiance, 3, 3, 3, 1e-6F);
  EXPECT_TRUE(SceneFile(folder / "scene.gltf").has_light());
}

TEST_F(SceneFileTest, MetallicDecidesTheKind) {
  const auto pbr = [](double metallic, double roughness) {
    return json{{"pbrMetallicRoughness",
                 {{"metallicFactor", metallic},
                  {"roughnessFactor", roughness},
                  {"baseColorFactor", {0.2, 0.4, 0.6, 1}}}}};
  };
  const Material coated = material(pbr(0, 0.5));
  EXPECT_EQ(coated.kind, MaterialKind::plastic);
  EXPECT_FLOAT_EQ(coated.roughness, 0.5F);
  EXPECT_FLOAT_EQ(coated.ior, 1.5F);
  EXPECT_VEC3(coated.colour.colour_a, 0.2F, 0.4F, 0.6F, 1e-6F);
  EXPECT_FALSE(coated.emission || coated.opacity);
  EXPECT_EQ(material(pbr(1, 0.3)).kind, MaterialKind::rough_conductor);
  EXPECT_EQ(material(pbr(1, 0)).kind, MaterialKind::mirror);
  const Material between = material(pbr(0.25, 0.5));
  ASSERT_EQ(between.kind, MaterialKind::mixed);
  EXPECT_FLOAT_EQ(between.mask->colour_a.x, 0.25F);
  EXPECT_EQ(whole.materials.at(static_cast<size_t>(between.first)).kind, MaterialKind::plastic);
  EXPECT_EQ(whole.materials.at(static_cast<size_t>(between.second)).kind, MaterialKind::rough_conductor);

  json glass = pbr(0, 0);
  glass["extensions"] = {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                         {"KHR_materials_ior", {{"ior", 1.33}}}};
  gltf.root["extensionsUsed"] = {"KHR_materials_transmission", "KHR_materials_ior"};
  const Material clear = material(glass);
  EXPECT_EQ(clear.kind, MaterialKind::smooth_dielectric);
  EXPECT_FLOAT_EQ(clear.ior, 1.33F);
}

TEST_F(SceneFileTest, EmissionOpacityAndOwnKinds) {
  const Material lamp =
      material({{"emissiveFactor", {1, 0.5, 0.25}},
                {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 20}}}}}});
  ASSERT_TRUE(lamp.emission.has_value());
  EXPECT_VEC3(lamp.emission->colour_a, 20, 10, 5, 1e-4F);

  const json half = {{"baseColorFactor", {1, 1, 1, 0.5}}};
  EXPECT_FALSE(material({{"pbrMetallicRoughness", half}}).opacity)
      << "alpha counts for nothing in OPAQUE materials";
  EXPECT_FLOAT_EQ(material({{"pbrMetallicRoughness", half}, {"alphaMode", "BLEND"}}).opacity->colour_a.x,
                  0.5F);
  EXPECT_FALSE(
      material({{"pbrMetallicRoughness", half}, {"alphaMode", "MASK"}, {"alphaCutoff", 0.4}}).opacity);
  EXPECT_EQ(material({{"pbrMetallicRoughness", half}, {"alphaMode", "MASK"}, {"alphaCutoff", 0.6}})
                .opacity->colour_a.x,
            0);

  const auto own = [](const json& ld) { return json{{"extras", {{"ld", ld}}}}; };
  const Material plain = material(own({{"kind", "diffuse"}}));
  EXPECT_EQ(plain.kind, MaterialKind::diffuse);
  EXPECT_EQ(plain.roughness, 1);
  const Material gold = material(
      own({{"kind", "rough_conductor"}, {"roughness", 0.3}, {"eta", {0.1, 0.4, 1.4}}, {"k", {4, 2.4, 1.6}}}));
  EXPECT_EQ(gold.kind, MaterialKind::rough_conductor);
  EXPECT_FLOAT_EQ(gold.roughness, 0.3F);
  EXPECT_VEC3(gold.metal_k, 4, 2.4F, 1.6F, 1e-6F);
  const Material glass = material(own({{"kind", "smooth_dielectric"}, {"ior", 1.7}}));
  EXPECT_EQ(glass.kind, MaterialKind::smooth_dielectric);
  EXPECT_FLOAT_EQ(glass.ior, 1.7F);
  EXPECT_ERROR(material(own({{"kind", "velvet"}})), "extras.ld.kind: expected one of diffuse");
}

TEST_F(SceneFileTest, AnimationIsMotionOverTheShutter) {
  // A quarter turn about y and a way of 4 along x in one second, under a parent that doubles everything.
  const float h = std::sqrt(0.5F);
  gltf.root["scenes"][0]["nodes"] = {1};
  gltf.root["nodes"] = {{{"mesh", 0}}, {{"children", {0, 2}}, {"scale", {2, 2, 2}}}, {{"camera", 0}}};
  gltf.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}}};
  gltf.animate(0, "rotation", {0, 0, 0, 1, 0, h, 0, h});
  gltf.animate(0, "translation", {0, 0, 0, 4, 0, 0});
  gltf.animate(2, "translation", {0, 0, 5, 0, 0, 7});
  const SceneFile file(gltf.write(folder / "scene.gltf"));
  EXPECT_NEAR(file.duration(), 1, 1e-6);

  const FrameTimes times = {0.25, 0.5, 0.125};
  const Scene open = file.scene(times);
  const Object& object = open.objects[0];
  EXPECT_NEAR(object.motion.angle, 0.25F * kPi / 2, 1e-5F);
  EXPECT_NEAR(std::abs(object.motion.axis.y), 1, 1e-5F);
  EXPECT_VEC3(object.motion.translation, 2, 0, 0, 1e-5F);
  const Mesh close = file.scene({0.5, 0.5, 0.5}).objects[0].mesh;
  const Mesh before = file.scene({0.125, 0.125, 0.125}).objects[0].mesh;
  for (size_t i = 0; i < close.positions.size(); ++i) {
    const Vec3 moved = object.motion.point(object.mesh.positions[i], 1);
    EXPECT_VEC3(moved, close.positions[i].x, close.positions[i].y, close.positions[i].z, 1e-4F);
    const Vec3 back = object.previous.point(object.mesh.positions[i], 1);
    EXPECT_VEC3(back, before.positions[i].x, before.positions[i].y, before.positions[i].z, 1e-4F);
  }

  const Camera camera = file.camera(0, times);
  EXPECT_TRUE(camera.shutter);
  EXPECT_VEC3(camera.position, 0, 0, 11, 1e-4F);
  ASSERT_TRUE(camera.close && camera.previous);
  EXPECT_VEC3(camera.close->position, 0, 0, 12, 1e-4F);
  EXPECT_VEC3(camera.previous->position, 0, 0, 10.5F, 1e-4F);
  // It stops at its last key.
  EXPECT_VEC3(file.scene({5, 5, 5}).objects[0].mesh.positions[0], 8, -2, 2, 1e-4F);
}

TEST_F(SceneFileTest, ProbeOfTheFile) {
  gltf.root["scenes"][0]["extras"]["ld"]["probe"] = {{"uri", "none.exr"}, {"scale", 2}};
  EXPECT_ERROR(scene(), "none.exr");
  const Probe probe = read_probe(kModels + "glTF2/BoxTextured-glTF/CesiumLogoFlat.png", grey(2), kPi / 2);
  EXPECT_VEC3(probe.orientation.z, 1, 0, 0, 1e-6F);  // the middle column, -z, now lies towards -x
}

TEST(SceneFileModels, TexturesComeFromFilesBuffersAndText) {
  const auto read = [](const std::string& name) {
    return SceneFile(kModels + "glTF2/" + name).scene(kStart);
  };
  const Scene beside = read("BoxTextured-glTF/BoxTextured.gltf");
  for (const Scene& scene : {beside, read("BoxTextured-glTF-Binary/BoxTextured.glb"),
                             read("BoxTextured-glTF-Embedded/BoxTextured.gltf")}) {
    ASSERT_EQ(scene.objects.size(), 1U);
    EXPECT_EQ(scene.objects[0].mesh.triangles.size(), 12U);
    EXPECT_EQ(scene.objects[0].mesh.uvs.size(), scene.objects[0].mesh.positions.size());
    const Texture& colour = scene.materials[static_cast<size_t>(scene.objects[0].material)].colour;
    ASSERT_TRUE(colour.image != nullptr);
    EXPECT_EQ(colour.image->width, 211);
    const Texture& same = beside.materials[static_cast<size_t>(beside.objects[0].material)].colour;
    EXPECT_EQ(colour.image->texels[5000].x, same.image->texels[5000].x);
  }
}

TEST(SceneFileModels, EngineOfManyParts) {
  const SceneFile file(kModels + "glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb");
  const Scene scene = file.scene(kStart);
  EXPECT_EQ(file.camera_count(), 1U);
  EXPECT_EQ(scene.objects.size(), 115U) << "each primitive of each node's mesh, counted in the JSON";
  EXPECT_FALSE(file.has_light());
  const Camera camera = file.camera(0, kStart);
  EXPECT_GT(camera.depth(file.bounds(0).centre()), 0) << "the camera looks at the engine";
  const Scene obj = SceneFile(kModels + "OBJ/spider.obj").scene(kStart);
  EXPECT_GT(obj.objects.size(), 10U);
}

TEST_F(SceneFileTest, WhatLiesBeyondABufferIsNotRead) {
  const nlohmann::json original = gltf.root;
  const auto expect = [&](const nlohmann::json::json_pointer& place, const nlohmann::json& value,
                          const char* complaint) {
    gltf.root = original;
    gltf.root[place] = value;
    EXPECT_ERROR(scene(), complaint);
  };
  using Place = nlohmann::json::json_pointer;
  expect(Place("/accessors/0/byteOffset"), 5,
         "accessors[0]: expected 4 elements of 12 bytes within the 48 bytes of its view");
  expect(Place("/accessors/0/count"), 5, "accessors[0]: expected 5 elements");
  expect(Place("/accessors/0/count"), uint64_t{1} << 40, "accessors[0]: expected 1099511627776 elements");
  expect(Place("/accessors/0/count"), -1, "accessors[0].count: expected a whole number");
  expect(Place("/accessors/0/componentType"), 5124, "accessors[0].componentType");
  expect(Place("/accessors/0/type"), "VEC5", "accessors[0].type");
  expect(Place("/accessors/0/bufferView"), 7, "accessors[0].bufferView: expected an index below 3");
  expect(Place("/bufferViews/0/byteStride"), 16, "accessors[0]: expected 4 elements");
  expect(Place("/bufferViews/0/byteStride"), 4, "bufferViews[0].byteStride: expected at least the 12 bytes");
  expect(Place("/bufferViews/0/byteLength"), 49,
         "bufferViews[0]: expected a place within the 48 bytes of its buffer");
  expect(Place("/accessors/0/count"), int64_t{0}, "accessors[0].count: expected at least 1");
  expect(Place("/meshes/0/primitives/0/attributes"), nlohmann::json::object(),
         "POSITION: expected an index below 3");
  const nlohmann::json place = {{"bufferView", 0}, {"byteOffset", 40}};
  nlohmann::json indices = place;
  indices["componentType"] = 5123;
  expect(Place("/accessors/0/sparse"), {{"count", 5}, {"indices", indices}, {"values", place}},
         "sparse.count: expected at most");
  expect(Place("/accessors/0/sparse"), {{"count", 1}, {"indices", indices}, {"values", place}},
         "sparse.values: expected 1 elements");
}

TEST_F(SceneFileTest, AStripOfTooFewVerticesIsAnError) {
  nlohmann::json& primitive = gltf.root["meshes"][0]["primitives"][0];
  primitive.erase("indices");
  for (const auto& [mode, least] : std::vector<std::pair<int, int>>{{2, 2}, {3, 2}, {5, 3}, {6, 3}}) {
    primitive["mode"] = mode;
    gltf.root["accessors"][0]["count"] = least - 1;
    EXPECT_ERROR(scene(), fmt::format("accessors[0].count: expected at least {}", least));
  }
}

TEST_F(SceneFileTest, BrokenFilesGiveOneClearLine) {
  const auto text = [&](const char* name, const std::string& bytes) {
    write_file_atomically(folder / name, bytes);
    return folder / name;
  };
  EXPECT_ERROR(SceneFile(folder / "none.gltf"), "none.gltf");
  EXPECT_ERROR(SceneFile(text("a.gltf", "{\"asset\": ")), "not valid JSON");
  EXPECT_ERROR(SceneFile(text("b.gltf", "{}")), "asset.version");
  EXPECT_ERROR(SceneFile(text("c.glb", std::string("glTF\2\0\0\0\0\1\0\0", 12))), "truncated");
  EXPECT_ERROR(SceneFile(text("d.obj", "f 1 2 3\n")), "d.obj");
  for (const char* name :
       {"MissingBin/BoxTextured.gltf", "RecursiveNodes/RecursiveNodes.gltf",
        "SchemaFailures/sceneWrongType.gltf", "TestNoRootNode/NoScene.gltf",
        "TestNoRootNode/SceneWithoutNodes.gltf", "wrongTypes/badArray.gltf",
        "BoxWithInfinites-glTF-Binary/BoxWithInfinites.glb", "IndexOutOfRange/AllIndicesOutOfRange.gltf"})
    EXPECT_ERROR(SceneFile(kModels + "glTF2/" + name), name);
  gltf.root["nodes"][0]["camera"] = 3;
  EXPECT_ERROR(scene(), "nodes[0].camera: expected an index below 0, found 3");
  gltf.root["nodes"][0].erase("camera");
  gltf.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
  gltf.root["textures"] = {{{"source", 0}}};
  gltf.root["images"] = {{{"uri", "gone.png"}}};
  EXPECT_ERROR(scene(), "gone.png is not there");
}

TEST_F(SceneFileTest, SkinsWithoutMatricesAreReadAsIfTheyWereNotThere) {
  const size_t triangles = scene().objects[0].mesh.triangles.size();
  gltf.root["skins"] = {{{"joints", {0}}}};
  gltf.root["nodes"][0]["skin"] = 0;
  EXPECT_EQ(scene().objects[0].mesh.triangles.size(), triangles);
}

/// Every prefix of a good file, and every file with a stretch of it zeroed: an Error or a scene, nothing
/// else.
TEST_F(SceneFileTest, DamagedBytesNeverCrash) {
  const std::string good = read_file(kModels + "glTF2/BoxTextured-glTF-Binary/BoxTextured.glb");
  int refused = 0;
  for (size_t cut = 0; cut < good.size(); cut += good.size() / 60 + 1) {
    for (const bool zeroed : {false, true}) {
      std::string bytes = zeroed ? good : good.substr(0, cut);
      if (zeroed)
        bytes.replace(cut, std::min<size_t>(40, bytes.size() - cut), std::min<size_t>(40, bytes.size() - cut),
                      '\0');
      write_file_atomically(folder / "damaged.glb", bytes);
      try {
        SceneFile(folder / "damaged.glb").scene(kStart);
      } catch (const Error& error) {
        ++refused;
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
  }
  EXPECT_GE(refused, 60) << "all that were cut short";
}

TEST_F(SceneFileTest, ChecksumCoversWhatTheFileRefersTo) {
  write_file_atomically(folder / "picture.png",
                        read_file(kModels + "glTF2/BoxTextured-glTF/CesiumLogoFlat.png"));
  gltf.root["images"] = {{{"uri", "picture.png"}}};
  gltf.write(folder / "scene.gltf");
  SceneFileConfig config;
  config.path = "scene.gltf";
  resolve(config, folder.path());
  EXPECT_EQ(config.path, (folder / "scene.gltf").string());
  SceneFileConfig again = config;
  resolve(again, "");
  EXPECT_EQ(again.checksum, config.checksum);
  write_file_atomically(folder / "picture.png", "another");
  EXPECT_ERROR(resolve(again, ""), "was changed");
  again.path = "none.gltf";
  EXPECT_ERROR(resolve(again, ""), "none.gltf");
}

}  // namespace
}  // namespace ld
