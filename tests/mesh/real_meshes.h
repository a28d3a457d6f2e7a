#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "relief/core/polygon_mesh.h"

/// Real models for tests of this module, which does not know files: just vertices and faces.
namespace relief::test {

/// Without vertices if the file is not there.
inline PolygonMesh real_mesh(const std::string& name) {
    const char* folder = std::getenv("RELIEF_DATA");
    std::ifstream file(std::string(folder ? folder : RELIEF_SHARED_DATA) + "/meshes/" + name);
    PolygonMesh mesh;
    std::string line;
    std::size_t announced = 0;  // OFF: vertices
    const bool off = name.ends_with(".off");
    while (std::getline(file, line)) {
        std::istringstream words(line);
        std::string word;
        if (line.empty() || line[0] == '#' || line == "OFF" || !(words >> word)) continue;
        std::vector<std::int32_t> face;
        if (off && announced == 0) {
            announced = std::stoul(word);
        } else if (word == "v" || (off && mesh.vertices.size() < announced)) {
            std::array<double, 3> p{};
            if (off) p[0] = std::stod(word);
            for (std::size_t k = off ? 1 : 0; k < 3; ++k) words >> p[k];
            mesh.vertices.push_back(p);
        } else if (off) {
            for (int k = std::stoi(word); k > 0 && words >> word; --k)
                face.push_back(std::stoi(word));
        } else if (word == "f") {
            while (words >> word) face.push_back(std::stoi(word) - 1);
        }
        if (!face.empty()) mesh.add_polygon(face);
    }
    return mesh;
}

}  // namespace relief::test
