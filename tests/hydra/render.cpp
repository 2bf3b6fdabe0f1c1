// SPDX-License-Identifier: Apache-2.0
// irt_hydra_render STAGE CAMERA WIDTH HEIGHT FILE [index|delegate] [TIME...]: films as raw floats,
// RGBA, the lowest row first, one after the other.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "host.h"

PXR_NAMESPACE_USING_DIRECTIVE

int main(int argc, char** argv) {
    if (argc < 6) {
        std::cerr << "usage: irt_hydra_render STAGE CAMERA WIDTH HEIGHT FILE [index|delegate] "
                     "[TIME...]\n";
        return 2;
    }
    const UsdStageRefPtr stage = UsdStage::Open(argv[1]);
    if (!stage) return 2;
    const bool older = argc > 6 && std::string(argv[6]) == "delegate";
    Host host(stage, older ? Path::SceneDelegate : Path::SceneIndex);
    HostView& view = host.AddView(argv[2], std::atoi(argv[3]), std::atoi(argv[4]));
    std::ofstream file(argv[5], std::ios::binary);
    for (int i = 7; i == 7 || i < argc; ++i) {
        if (i < argc) host.SetTime(std::atof(argv[i]));
        host.Render();
        const Pixels pixels = view.Read(HdAovTokens->color);
        file.write(reinterpret_cast<const char*>(pixels.data()),
                   static_cast<std::streamsize>(pixels.size() * sizeof(float)));
        for (const auto& [name, value] : host.Delegate().GetRenderStats())
            std::cout << name << " " << value << "\n";
    }
    return file.good() ? 0 : 1;
}
