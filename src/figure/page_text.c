/* SPDX-License-Identifier: MIT */
#include "figure/page_text.h"

#include <math.h>
#include <string.h>

#include "report/gnuplot.h"

/* Returns the width of a letter of DejaVu Sans in em, in a few classes and rather too wide. */
static double letter_em(char c)
{
    if (strchr("ijl.,:;'|!", c))
        return 0.34;
    if (strchr(" ft-()/I", c))
        return 0.4;
    if (strchr("mwMWOQ%@+=", c))
        return 0.95;
    return c >= 'A' && c <= 'Z' ? 0.72 : 0.64;
}

double iso_page_text_width_mm(const char *s, size_t bytes, double pt)
{
    const double mm_per_pt = 25.4 / 72;
    double em = 0;
    for (size_t i = 0; i < bytes; ++i)
        if ((unsigned char)s[i] >= 0xc0) /* first byte of a character that is not ASCII: a minus sign */
            em += 0.84;
        else if ((unsigned char)s[i] < 0x80)
            em += letter_em(s[i]);
    return em * pt * mm_per_pt;
}

/* ---- numbers ---- */

void iso_page_power_of_ten(int exponent, char text[24])
{
    static const char *const raised[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    char digits[16];
    snprintf(digits, sizeof digits, "%d", exponent);
    snprintf(text, 24, "10");
    for (const char *d = digits; *d; ++d)
        strcat(text, *d == '-' ? "⁻" : raised[*d - '0']);
}

/* Writes a number from 0 on with the decimals that tell it from one `apart`, without zeros at the end. */
static void write_decimal(double value, double apart, char text[24])
{
    const int decimals = (int)fmin(fmax(ceil(-log10(apart) - 1e-6), 0), 9);
    size_t end = (size_t)snprintf(text, 24, "%.*f", decimals, value);
    if (!strchr(text, '.'))
        return;
    while (text[end - 1] == '0')
        text[--end] = 0;
    if (text[end - 1] == '.')
        text[--end] = 0;
}

void iso_page_number(double value, double apart, char text[64])
{
    const double size = rint(fabs(value) / apart) * apart;
    const char *sign = value < 0 && size > 0 ? "−" : "";
    char factor[24], power[24];
    if (!(size > 0) || (size < 1e5 && size >= 0.001)) {
        write_decimal(size, apart, factor);
        snprintf(text, 64, "%s%s", sign, factor);
        return;
    }
    const int exponent = (int)floor(log10(size) + 1e-9);
    write_decimal(size / pow(10, exponent), apart / pow(10, exponent), factor);
    iso_page_power_of_ten(exponent, power);
    snprintf(text, 64, "%s%s%s%s", sign, strcmp(factor, "1") == 0 ? "" : factor, strcmp(factor, "1") == 0 ? "" : "×",
             power);
}

/* ---- LaTeX ---- */

/* Characters with other spellings in LaTeX. The paper's encoding covers the rest of UTF-8. */
static const struct {
    const char *utf8, *latex;
} replaced[] = {
    {"\\", "\\textbackslash{}"},
    {"{", "\\{"},
    {"}", "\\}"},
    {"$", "\\$"},
    {"%", "\\%"},
    {"&", "\\&"},
    {"#", "\\#"},
    {"_", "\\_"},
    {"^", "\\textasciicircum{}"},
    {"~", "\\textasciitilde{}"},
    {"<", "$<$"},
    {">", "$>$"},
    {"|", "$|$"},
    {"\"", "\'\'"},
    {"−", "$-$"},
    {"×", "$\\times$"},
    {"°", "$^\\circ$"},
    {"µ", "$\\mu$"},
    {"Å", "\\AA{}"},
    {"σ", "$\\sigma$"},
    {"θ", "$\\theta$"},
    {"φ", "$\\varphi$"},
    {"Δ", "$\\Delta$"},
    {"≤", "$\\leq$"},
    {"≥", "$\\geq$"},
    {"⁰", "$^0$"},
    {"¹", "$^1$"},
    {"²", "$^2$"},
    {"³", "$^3$"},
    {"⁴", "$^4$"},
    {"⁵", "$^5$"},
    {"⁶", "$^6$"},
    {"⁷", "$^7$"},
    {"⁸", "$^8$"},
    {"⁹", "$^9$"},
    {"⁻", "$^-$"},
    {"–", "--"},
    {"…", "\\ldots{}"},
};

static size_t find_replaced(const char *s)
{
    size_t i = 0;
    while (i < sizeof replaced / sizeof *replaced && strncmp(s, replaced[i].utf8, strlen(replaced[i].utf8)) != 0)
        ++i;
    return i;
}

static void put_latex(FILE *gp, const char *text)
{
    char out[1024];
    size_t used = 0;
    for (const char *s = text; *s && used + 32 < sizeof out;) {
        const size_t i = find_replaced(s);
        if (i == sizeof replaced / sizeof *replaced) {
            out[used++] = *s++;
            continue;
        }
        memcpy(out + used, replaced[i].latex, strlen(replaced[i].latex));
        used += strlen(replaced[i].latex);
        s += strlen(replaced[i].utf8);
    }
    out[used] = 0;
    iso_gnuplot_put_quoted(gp, out);
}

void iso_page_text_put(FILE *gp, const char *role_pt, const char *text)
{
    fprintf(gp, "say(%s, ", role_pt);
    iso_gnuplot_put_quoted(gp, text);
    fputs(", ", gp);
    put_latex(gp, text);
    fputc(')', gp);
}
