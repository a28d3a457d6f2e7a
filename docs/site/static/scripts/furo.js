// Instead of Furo's own script, which Debian ships as a module that pages opened from files can not load, and of its
// style for dark systems, which Debian's lacks: the system's theme, and a button that changes it and is remembered.
document.documentElement.classList.replace("no-js", "js");

const dark = matchMedia("(prefers-color-scheme: dark)").matches;
const stored = localStorage.getItem("theme");
document.body.dataset.theme = stored === "light" || stored === "dark" ? stored : dark ? "dark" : "light";

for (const button of document.getElementsByClassName("theme-toggle"))
    button.addEventListener("click", () => {
        const theme = document.body.dataset.theme === "dark" ? "light" : "dark";
        document.body.dataset.theme = theme;
        localStorage.setItem("theme", theme);
    });
