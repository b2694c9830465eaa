/* Browsers start no worker from a page that was read from a folder. There the search, which is one, runs in
   a hidden frame instead; read from a server this script does nothing. */
(() => {
  if (location.protocol !== "file:") return;

  const load = (page, address) =>
    new Promise((loaded, failed) => {
      const script = page.createElement("script");
      script.src = address;
      script.onload = loaded;
      script.onerror = failed;
      page.body.append(script);
    });

  // The theme's search looks for this name, to find its own files.
  class IFrameWorker extends EventTarget {
    constructor(address) {
      super();
      this.onmessage = this.onerror = null;
      this.frame = document.createElement("iframe");
      this.frame.hidden = true;
      this.frame.title = "search";
      document.body.append(this.frame);
      const inside = this.frame.contentWindow;
      const page = this.frame.contentDocument;
      inside.postMessage = (data) => {
        const event = new MessageEvent("message", { data });
        this.dispatchEvent(event);
        if (this.onmessage) this.onmessage(event);
      };
      inside.importScripts = (...files) =>
        files.reduce((before, file) => before.then(() => load(page, file)), Promise.resolve());
      this.ready = load(page, String(address));
    }

    postMessage(data) {
      const inside = this.frame.contentWindow;
      this.ready.then(() => inside.dispatchEvent(new inside.MessageEvent("message", { data })));
    }

    terminate() {
      this.frame.remove();
    }
  }

  window.IFrameWorker = IFrameWorker;
  window.Worker = IFrameWorker;
})();
