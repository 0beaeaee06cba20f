/* SPDX-License-Identifier: MIT */
/* make_gipl.cc - made phantom.gipl in this folder, by ITK 5.2 of Debian 12, of the samples of phantom.py's phantom():
 *     make_gipl phantom.raw phantom.gipl */
#include <itkGiplImageIO.h>
#include <cstdio>
#include <vector>
int main(int, char **argv)
{
    std::vector<short> v(11 * 13 * 7);
    FILE *f = fopen(argv[1], "rb");
    if (!f || fread(v.data(), 2, v.size(), f) != v.size())
        return 1;
    auto io = itk::GiplImageIO::New();
    io->SetNumberOfDimensions(3);
    const double spacing[] = {0.75, 0.5, 2.5}, origin[] = {1, 2, 3};
    const int size[] = {11, 13, 7};
    itk::ImageIORegion region(3);
    for (int a = 0; a < 3; ++a)
        io->SetDimensions(a, size[a]), io->SetSpacing(a, spacing[a]), io->SetOrigin(a, origin[a]),
            region.SetSize(a, size[a]), region.SetIndex(a, 0);
    io->SetComponentType(itk::IOComponentEnum::SHORT);
    io->SetPixelType(itk::IOPixelEnum::SCALAR);
    io->SetNumberOfComponents(1);
    io->SetIORegion(region);
    io->SetFileName(argv[2]);
    io->Write(v.data());
}
