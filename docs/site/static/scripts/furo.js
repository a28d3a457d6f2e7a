// Instead of Furo's own script, which Debian ships as a module that pages opened from files can not load:
// the button that goes from the system's theme to light and dark, kept for the next visit.
const root = document.documentElement;
root.classList.replace("no-js", "js");

const themes = ["auto", "light", "dark"];

function setTheme(theme) {
    document.body.dataset.theme = theme;
    localStorage.setItem("theme", theme);
}

window.addEventListener("DOMContentLoaded", () => {
    for (const button of document.getElementsByClassName("theme-toggle"))
        button.addEventListener("click", () =>
            setTheme(themes[(themes.indexOf(document.body.dataset.theme) + 1) % themes.length]));
});
